"""What --help says is taken apart alike however CLI11 orders the options that one excludes: tests/check/program_help.py."""
import itertools
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "deploy"))
from program_help import parse


def help_with(excluded):
    option = f"  --token TEXT (Env:ISOSTRATA_TOKEN) Excludes: {' '.join(excluded)}"
    return f"Serves\nUsage: isostrata serve [OPTIONS]\n\nOptions:\n{option}\n{' ' * 30}Token to ask for\n  --step INT Excludes: --time  Time step\n"


read = [parse(help_with(order)) for order in itertools.permutations(["--token-file", "--no-auth", "--a"])]
wanted = {"Options": [("--token TEXT (Env:ISOSTRATA_TOKEN) Excludes: --a --no-auth --token-file", "Token to ask for"), ("--step INT Excludes: --time", "Time step")]}
for _, _, sections in read:
    if sections != wanted:
        sys.exit(f"got {sections}\nexpected {wanted}")
