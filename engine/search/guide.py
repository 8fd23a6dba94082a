"""The page that lies in every run directory: what its files are, and what their columns mean, with units."""

GUIDE = "README.md"

TEXT = """\
# Results of a search by cortexc

| file | holds |
|---|---|
| `worst/01.scn` … | the worst cases, each a scenario: `cortexc worst/01.scn` shows the same outcome again |
| `summary.json` | settings and versions, figures of the whole search, worst cases, what each gene did |
| `evaluations.csv` | one row for each rollout of each individual; an elite's rows are repeated, `reused` is 1 |
| `evaluations.jsonl` | the same, one JSON object a line; `tested` and `failed` count the attempts of each requirement |
| `critical.csv` | the rows of `evaluations.csv` with a score of 14 or more |
| `generations.csv` | the figures of each generation |
| `journal.sqlite` | everything, exactly; the other files are made from it |

## Columns of `evaluations.csv`

An empty cell is a number that does not exist. Times count from the start of the run.

| column | meaning |
|---|---|
| `individual` | number of the individual, from 0 |
| `generation`, `place` | where it stands |
| `rollout` | number of the scene drawn for this individual, from 0 |
| `operator` | how it came to be: `random`, `elite`, `crossover`, `mutation`, `crossover_mutation` |
| `reused` | 1: an elite that was not simulated again |
| `birth` | the individual that was simulated first; its own number unless reused |
| `parent_1`, `parent_2` | individuals that it was made from |
| `key` | names the random numbers of this simulation |
| `param_…` | the params, in the units of the file (see `summary.json`); of a choice, the number of its option |
| `fitness` | score of the individual over its rollouts, -1 if invalid |
| `verdict` | `valid`; `exhausted`, `infeasible`, `aborted`: no valid scene; `error`: the engine failed |
| `variant` | number of the combination of lanes and other finite choices, -1: none |
| `attempts` | attempts to draw the scene |
| `score` | risk, 0 to 22, -1 if invalid |
| `risk_c`, `risk_md`, `risk_d_ms`, `risk_ttc_ms` | its parts |
| `continuous` | the same without steps |
| `pair` | who decided the score: actor `pair` + 1, where the ego is actor 0 |
| `collided` | 1: the ego touched another actor |
| `end_reason` | `collision`, `other_collision` (without the ego), `rule`, `timeout`, `all_done`, `stuck`, `broken` |
| `end_rule` | of `rule`: its number among the rules in `summary.json`, else -1 |
| `end_time` | end of the run [s] |
| `min_distance`, `min_distance_time` | MD, least distance of the ego's outline to another [m], and when [s] |
| `max_closing_speed`, `max_closing_time` | MS, fastest closing speed of that pair [m/s], and when [s] |
| `distance_at_ms` | D_MS, their distance then [m] |
| `ttc_at_ms` | TTC_MS = D_MS / MS [s] |
| `ego_speed`, `other_speed` | of that pair at its closest approach, or at contact [m/s] |
| `approach_angle` | heading of the other then, seen from the ego [rad]: 0 the same way, +-3.14 head-on, positive left |
| `closing_speed` | of their centres then [m/s] |
| `side` | of the ego on which the other is then: `front`, `left`, `rear`, `right` |
| `left_road_time` | when the first actor left the road [s] |

## Columns of `generations.csv`

First by individual, elites included; then, as `simulated_…`, over distinct simulations only.

| column | meaning |
|---|---|
| `generation` | from 0 |
| `individuals`, `valid` | how many, and how many of them with a valid scene |
| `rl`, `rl_all` | RL, mean score of the valid ones; and with every invalid one as -1 |
| `nc` | NC, individuals with a collision |
| `mdg`, `mdec` | MDG, mean MD of the valid ones [m]; MDEC, of those without a collision [m] |
| `nis` | NIS, invalid individuals |
| `errors` | individuals that the engine failed on; they count nowhere |
| `runs`, `valid_runs`, `colliding_runs`, `invalid_runs`, `error_runs` | the same by rollout |
"""
