"""`new`: classes and properties of objects, and where they are."""
