"""Pages: a run, a case or a study as one HTML file that needs nothing else, and drawings for notebooks and papers.

`element` builds markup and escapes it, `drawing` and `charts` make SVG, `document` puts a page around sections.
"""
