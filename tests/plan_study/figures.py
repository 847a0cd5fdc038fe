#!/usr/bin/env python3
"""The figures of docs/PLAN.md, each from one command. Long: a study, not a test.

usage: figures.py FIGURE [--build=build/release] [--shared=../shared]

elastostatic  15 configurations of a KR 270 on five levels of axis 2 against the published 15
geometric     18 configurations of a KR 270 against 1000 random sets, prediction against simulation
ur5           20 of 1000 measured poses of a UR5, judged on poses that are in no plan
ur10          40 of 1495 measured poses of a UR10 for the poses of two other series
fig7          paper 002, Fig. 7, Tables IX and XIII: heuristic and optimal poses, with and without compensator
discriminate  ten pairs of explanations that share the probability: six planned poses, six random ones
speed         100000 candidates, 61 parameters, 50 poses
"""
import argparse
import importlib
import pathlib
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
FIGURES = {"elastostatic": "kr270_figures", "geometric": "kr270_figures", "speed": "kr270_figures",
           "fig7": "paper_figures", "discriminate": "tied_figures", "ur5": "measured_figures", "ur10": "measured_figures"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("figure", choices=sorted(FIGURES))
    parser.add_argument("--build", type=pathlib.Path, default=HERE.parents[1] / "build/release")
    parser.add_argument("--shared", type=pathlib.Path, default=HERE.parents[1] / "../shared")
    parser.add_argument("--random", type=int, default=0, help="random sets, where a figure compares with some; campaigns of each pair of discriminate")
    options = parser.parse_args()
    sys.path[:0] = [str(HERE), str(options.build / "python")]
    with tempfile.TemporaryDirectory() as folder:
        figure = getattr(importlib.import_module(FIGURES[options.figure]), options.figure)
        figure(pathlib.Path(folder), options)


if __name__ == "__main__":
    main()
