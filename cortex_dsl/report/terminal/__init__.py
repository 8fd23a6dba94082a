"""Terminal output, drawn with rich: views of findings, and progress of running work."""
