"""Services for editors: colours, a grammar for them to load, and a language server."""
