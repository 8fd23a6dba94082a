"""Results of a run, a search or a study: their numbers, sentences and outputs.

`findings` holds the numbers and the sentences, each computed and worded once. Three outputs show them: `terminal`
with rich, `page` as HTML, pictures and films, and `documents` as JSON for other programs. Findings know none of the
three, and `terminal` and `page` do not know each other.
"""
