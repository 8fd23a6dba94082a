"""omega-prime: its own check of the columns, and whether everybody is there at every sample."""

import omega_prime
import polars
from answering import answer


def check(job: dict) -> list[str]:
    """A table is valid, and nobody and no row is missing."""
    if job["file"].endswith(".csv"):
        recording = omega_prime.Recording(df=polars.read_csv(job["file"]), validate=True)
    else:
        recording = omega_prime.Recording.from_parquet(job["file"], validate=True)
    found = []
    if len(recording.moving_objects) != job["movers"]:
        found.append(f"{len(recording.moving_objects)} movers of {job['movers']}")
    if len(recording.df) != job["rows"]:
        found.append(f"{len(recording.df)} rows of {job['rows']}")
    return found


answer(check)
