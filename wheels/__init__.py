"""How a wheel gets its compiled kernels: `make wheel`. No part of the product."""
