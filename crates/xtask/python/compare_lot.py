"""The raw stage of zerorate-lot beside DuckDB and a plain loop, on the same rows: speed, and the same sums."""

import json
import subprocess
import sys
import time

import duckdb

lot, raw, sums, rows, plain = sys.argv[1:6]
rows, plain = int(rows), json.loads(plain)
ROUNDS = 3

QUERY = f"""
SELECT group_number, axis, count(*) AS n, sum(temperature_counts::BIGINT) AS temperature_sum,
       sum(temperature_counts::BIGINT * temperature_counts) AS temperature_sq_sum, sum(zro_counts::BIGINT) AS zro_sum,
       sum(zro_counts::BIGINT * zro_counts) AS zro_sq_sum
FROM '{raw}' GROUP BY group_number, axis"""


def ours():
    """The seconds that the command measures of its query: what is compared is the engine, not the start of a process."""
    done = subprocess.run([lot, "group", raw, "--out", sums], check=True, capture_output=True, text=True)
    return float(done.stdout.split(" s\n")[0].rsplit(" ", 1)[1])


def duck():
    connection = duckdb.connect()
    began = time.perf_counter()
    connection.execute(f"CREATE OR REPLACE TEMP TABLE sums AS {QUERY}")
    return time.perf_counter() - began, connection


times = {"zerorate-lot": [], "DuckDB": []}
for _ in range(ROUNDS):
    times["zerorate-lot"].append(ours())
    seconds, connection = duck()
    times["DuckDB"].append(seconds)

names = 'group_number, axis, n, temperature_sum, temperature_sq_sum, zro_sum, zro_sq_sum'
differing = connection.execute(
    f"SELECT count(*) FROM ((SELECT {names} FROM sums EXCEPT SELECT {names} FROM '{sums}')"
    f" UNION ALL (SELECT {names} FROM '{sums}' EXCEPT SELECT {names} FROM sums))"
).fetchone()[0]
total = connection.execute("SELECT sum(zro_sq_sum)::BIGINT, count(*) FROM sums").fetchone()
assert differing == 0, f"{differing} rows of sums differ between zerorate-lot and DuckDB"
assert total[0] == plain["zro_sq_sum"], "the plain loop comes to another sum"

best = {name: min(seconds) for name, seconds in times.items()} | {"plain loop over memory, one thread": plain["seconds"]}
print(f"    {rows} raw samples to {total[1]} rows of sums, all the same; the best of {ROUNDS} runs")
for name, seconds in best.items():
    print(f"    {name:36} {seconds:8.3f} s  {rows / seconds / 1e6:8.1f} million rows/s")
ratio = best["DuckDB"] / best["zerorate-lot"]
print(f"    zerorate-lot runs at {ratio:.2f} of DuckDB {duckdb.__version__}'s speed")
