"""Analysis of a search's failures: diversity, kinds, regions of the gene space, and the effect of each gene."""
