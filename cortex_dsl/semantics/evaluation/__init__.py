"""What expressions are worth: a module for each family."""
