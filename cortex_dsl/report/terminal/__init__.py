"""What a terminal shows, drawn with rich: views of findings, and progress while something runs."""
