"""The maker of roads that an OpenDRIVE file describes: linking (which lanes there are, and how they go on), fitting
(their centre lines as lines and arcs), surfaces (what they cover), and the network of it all.
"""
