"""The CORTEX-AVD paper's own numbers, and what its arithmetic says about them."""
