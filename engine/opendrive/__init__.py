"""ASAM OpenDRIVE files as they stand: roads, lanes, links and junctions. Knows no road of ours."""
