"""What editors ask for: colours, a grammar for them to load, and a language server."""
