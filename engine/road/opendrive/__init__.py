"""The maker of roads that an OpenDRIVE file describes.

lanes (which there are), linking (how they go on), fitting and drawing (their centre lines as lines and arcs, and their
borders), surfaces (what they cover), levels (which roads pass over others), remarks (what is odd about the file),
planning (all of that) and making (the network of it).
"""
