"""Measurement files as rows, and which of them are held out."""
import csv
import hashlib
import math


def rows_of(path):
    with open(path, newline='') as file:
        return list(csv.DictReader(file))


def write_rows(path, rows):
    with open(path, 'w', newline='') as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator='\n')
        writer.writeheader()
        writer.writerows(rows)


def held_out(rows, fraction=0.3, seed=1):
    """The split of FORMATS section 3."""
    configs = sorted({r['config'] for r in rows}, key=lambda c: hashlib.sha256(('%d:%s' % (seed, c)).encode()).hexdigest())
    return set(configs[:math.ceil(fraction * len(configs))])
