"""Pages: a run, a case or a study as one HTML file that needs nothing else, and drawings for notebooks and papers.

`markup` builds HTML and SVG, escapes it and puts a page around it; `scene_svg` and `charts` draw; `run_page`,
`case_page` and `study_page` are the whole pages; `paper_figures` and `film` write pictures for elsewhere.
"""
