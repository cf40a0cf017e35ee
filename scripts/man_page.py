#!/usr/bin/env python3
"""The man page of sightline, from what the program says of itself.

Usage: man_page.py BINARY [--write]

Prints the page; --write puts it into docs/deploy/sightline.1, which a test holds against the program.
"""

import re
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).resolve().parent.parent / "docs/deploy/sightline.1"
COMMANDS = [("serve",), ("check-config",), ("key", "new"), ("cast",), ("query",), ("mcp",), ("demo",), ("convert",)]

HEAD = r""".\" Written by scripts/man_page.py from the program's own help.
.TH SIGHTLINE 1 "" "sightline" "User commands"
.SH NAME
sightline \- exact ray queries against glTF scenes
.SH SYNOPSIS
.nf
"""
TAIL = r""".SH SIGNALS
.TP
SIGTERM, SIGINT
Stop: finish what has begun, at most for \fB\-\-drain\-seconds\fR. A second one stops at once.
.TP
SIGHUP
Read the files of \fB\-\-keys\fR and \fB\-\-config\fR again.
.SH EXIT STATUS
.TP
0
after a stop, for a hit of \fBcast\fR and \fBquery\fR, for all answers to \fB\-\-rays\fR, and if \fBcheck\-config\fR finds no mistake
.TP
1
if the only ray of \fBcast\fR or \fBquery\fR misses
.TP
2
for an error or a mistake
.SH ENVIRONMENT
.TP
SIGHTLINE_KEY
The key that \fBquery\fR and \fBmcp\fR send, unless \fB\-\-key\-file\fR names a file with one.
.TP
SSL_CERT_FILE
A file of certificates of authorities that they trust instead of the system's.
.SH FILES
The file of \fB\-\-config\fR is one JSON object, in which every flag of \fBserve\fR may stand under its name without
dashes. The file of \fB\-\-keys\fR has a line for each key, as \fBkey new\fR prints it.
"""


def escaped(text):
    text = text.replace("\\", r"\e").replace("-", r"\-")
    return r"\&" + text if text.startswith((".", "'")) else text


EXAMPLES = [
    ("Serve a demo scene on this machine, and ask what one ray meets",
     ["sightline serve --preload town=demo:town",
      "sightline query http://127.0.0.1:8080 town --origin 3,200,5 --direction 0,-1,0"]),
    ("Serve scenes that survive a restart, to other machines, for clients with a key",
     ["sightline key new --role write --name me",
      "sightline serve --listen 0.0.0.0:8080 --data /var/lib/sightline --keys keys.txt"]),
    ("Trace a ray through a file without a server", ["sightline cast house.glb --origin 0,100,0 --direction 0,-1,0"]),
    ("Trace a file of rays, and print distance and name of each hit as JSON",
     ["sightline cast demo:town --rays rays.txt --fields distance,node --format json"]),
    ("Check a file of settings before a reload", ["sightline check-config sightline.json"]),
]


def examples():
    """The section EXAMPLES."""
    parts = [".SH EXAMPLES\n"]
    for what, lines in EXAMPLES:
        parts.append(f".PP\n{escaped(what)}:\n.PP\n.nf\n.RS\n" + "".join(f"{escaped(line)}\n" for line in lines) + ".RE\n.fi\n")
    return "".join(parts)


def help_of(binary, command):
    """CLI11 2.4 (Debian 13) writes a default as "UINT [5]", 2.1 (Debian 12) as "UINT=5": it is read as the latter. The same holds
    for "Excludes:", which 2.4 writes into a line of its own."""
    text = subprocess.run([binary, *command, "--help"], capture_output=True, text=True, check=True, timeout=60).stdout
    text = re.sub(r"^( {2,4}-[^\n]*?) *\n +(Excludes: (?:--[a-z-]+ ?)+)", r"\1 \2", text, flags=re.MULTILINE)
    text = re.sub(r"^( {2}-[^\n]*?) \[([^\]\n]*)\](?: *$|(?=  ))", r"\1=\2", text, flags=re.MULTILINE)
    return re.sub(r" +Excludes:", " Excludes:", text).rstrip() + "\n"


# A flag as CLI11 shows it: names, then perhaps TYPE:CHECK=DEFAULT, "...", REQUIRED, and what it excludes.
FLAG = re.compile(r"(?P<name>\S+)(?: (?P<type>(?:ADDR:PORT|ID=FILE|[A-Z][A-Z,]*)\b)(?::(?P<check>\{[^}]*\}|[A-Z]+ in \[[^\]]*\]|[A-Z]+))?(?:=(?P<default>\S+))?)?"
                  r"(?P<more> \.\.\.)?(?P<required> REQUIRED)?(?: Excludes: (?P<excludes>--[a-z-]+(?: --[a-z-]+)*))? *")
METAVARS = {"UINT": "N", "INT": "N", "FLOAT": "NUMBER", "FILE": "FILE", "DIR": "FOLDER", "SECONDS": "SECONDS"}


def plain(flag, text):
    """(flag, text) as a man page writes them: --format text|json, "... Default: text. Not with --json."."""
    found = FLAG.fullmatch(flag)
    if not found:
        raise ValueError(f"a flag of another form: {flag!r}")
    name, check = found["name"], found["check"] or ""
    value = METAVARS.get(check) or METAVARS.get(found["type"] or "") or found["type"] or ""
    notes = []
    if check.startswith("{"):
        value = check.strip("{}").replace(",", "|")
    elif limits := re.fullmatch(r"[A-Z]+ in \[(\S+) - (\S+)\]", check):
        notes.append(f"From {limits[1]} to {limits[2]}.")
    if found["default"]:
        notes.append(f"Default: {found['default']}.")
    if found["excludes"]:
        notes.append(f"Not with {', '.join(found['excludes'].split())}.")
    if found["required"] and name.startswith("-"):
        notes.append("Required.")
    shown = name if not name.startswith("-") or not value else f"{name} {value}"
    return shown + (found["more"] or ""), ". ".join([text.rstrip("."), " ".join(notes)]) if notes else text


def entries(lines):
    """(heading or None, flag, text) of the lines below a command's usage. A long flag has its text in the next line.

    Raises ValueError for a flag without a text."""
    heading, flag = None, None
    for line in [*lines, "end:"]:
        if flag and not line.startswith(" " * 5):
            raise ValueError(f"a flag without a text: {flag!r}")
        if (found := re.fullmatch(r"\s*(?:\[Option Group: )?([^\s\[].*?)[\]:]", line)) and not line.startswith("   "):
            heading = found.group(1)
        elif found := re.fullmatch(r" {2,4}(-.*)", line):
            # One space ends a flag that is as wide as its column.
            flag = FLAG.match(found.group(1)).group()
            if text := found.group(1)[len(flag):]:
                yield heading, flag.rstrip(), text
                flag = None
        elif found := re.fullmatch(r" {2,4}(\S.*?)(?:  +(\S.*))?", line):
            yield heading, found.group(1), found.group(2) or ""
        elif flag and line.strip():
            yield heading, flag, line.strip()
            flag = None


def page(binary):
    helps = {command: help_of(binary, command).splitlines() for command in COMMANDS}
    parts = [HEAD]
    for lines in helps.values():
        parts.append(escaped(lines[1].removeprefix("Usage: ")) + "\n")
    parts.append(".fi\n.SH COMMANDS\n")
    for command, lines in helps.items():
        parts.append(f".SS {escaped(' '.join(command))}\n{escaped(lines[0][0].upper() + lines[0][1:])}.\n")
        last = None
        for heading, flag, text in entries(lines[2:]):
            if heading not in (None, last, "Options", "Positionals"):
                parts.append(f".PP\n{escaped(heading)}:\n")
            last = heading
            if not text and not flag.startswith("-"):
                parts.append(f"{escaped(flag)}\n")  # what a group of flags is for, behind its heading
            elif not flag.startswith("-h,"):
                flag, text = plain(flag, text)
                parts.append(f".TP\n\\fB{escaped(flag)}\\fR\n{escaped(text)}\n")
    return "".join(parts) + examples() + TAIL


if __name__ == "__main__":
    if "--write" in sys.argv:
        PAGE.write_text(page(sys.argv[1]), encoding="utf-8")
    else:
        print(page(sys.argv[1]), end="")
