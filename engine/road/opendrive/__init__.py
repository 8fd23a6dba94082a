"""The maker of roads that an OpenDRIVE file describes.

lanes (the lanes of a file), linking (their continuations), fitting and drawing (their centre lines as lines and arcs,
and their borders), surfaces (their areas), levels (roads that pass over others), remarks (defects of the file),
planning (all of that) and making (the network).
"""
