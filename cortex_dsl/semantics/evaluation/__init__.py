"""What expressions are worth: a module for each family, and one table that leads to them."""
