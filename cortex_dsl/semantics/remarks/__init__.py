"""What is said of a file that compiles, once all of its variants are known."""
