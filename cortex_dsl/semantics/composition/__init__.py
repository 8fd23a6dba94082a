"""Programs of several parts: imports, and modular scenarios."""
