"""Which programs there are, and what their --help says, taken apart: for deploy/man, deploy/reference, deploy/archive and deploy/sbom."""
import re
import subprocess
import sys

PACKAGED = ("isostrata", "isostrata-bench", "isostrata-import", "isostrata-import-all", "isostrata-client")
COLUMN = 30  # at which descriptions begin
USAGE = re.compile(r"^(?:Usage: )?(\S.*\[OPTIONS\].*?) *$", re.M)
PROGRAMS = {"isostrata": [], "isostrata-client": ["http://127.0.0.1:8080/"]}  # with what stands before a command


def help_of(program, *words):
    done = subprocess.run([program, *words, "--help"], capture_output=True, text=True)
    if done.returncode or not USAGE.search(done.stdout):
        sys.exit(f"{program} {' '.join(words)} --help printed no help: {done.stderr.strip()}")
    return done.stdout


def item(line, following, wrapped):
    """(name, description) of an option's first line. A name that reaches into the descriptions stands alone."""
    name, meaning = line[:COLUMN], line[COLUMN:]
    if not (name.endswith(" ") and meaning.strip()) if wrapped else following.startswith(" " * COLUMN):
        name, meaning = line, ""
    return in_one_order(re.sub(r",\s{2,}", ",", name.strip())), meaning.strip()


def in_one_order(name):
    """The options that one excludes or needs stand in the order of addresses in memory."""
    return re.sub(r"(Excludes|Needs):((?: --?[\w-]+)+)", lambda found: f"{found[1]}: {' '.join(sorted(found[2].split()))}", name)


def parse(text):
    """(description, usage, {section: [(name, description)]}), as CLI11 prints them: before 2.4 without wrapping, since then wrapped, in capitals."""
    found = USAGE.search(text)
    description, usage, rest = text[:found.start()], found.group(1), text[found.end():]
    sections, lines, wrapped = {}, [line.rstrip() for line in rest.splitlines()], not found.group().startswith("Usage: ")
    for number, line in enumerate(lines):
        if re.fullmatch(r"\S.*:", line):
            items = sections.setdefault(line[:-1].capitalize(), [])
        elif line.startswith(" " * COLUMN):
            items[-1] = (items[-1][0], f"{items[-1][1]} {line.strip()}".strip())
        elif line.strip():
            items.append(item(line, lines[number + 1] if number + 1 < len(lines) else "", wrapped))
    return " ".join(description.split()), usage, sections


def typed(program, words):
    """A command as one types it: `isostrata-client URL info`."""
    shown = ["URL" if word in PROGRAMS[program] else word for word in (program, *words)]
    if words[-1:] in (["tunnel"], ["view"]) and "URL" in shown:
        shown.remove("URL")  # they find the URL
    return " ".join(shown)


def commands(build, program, words=()):
    """(words, text of --help, names of its commands) of a program and of all commands below it."""
    text = help_of(build / "bin" / program, *words)
    names = [name for name, _ in parse(text)[2].get("Subcommands", [])]
    yield list(words), text, names
    for name in names:
        yield from commands(build, program, [*(words or PROGRAMS[program]), name])
