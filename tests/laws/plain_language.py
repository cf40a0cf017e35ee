#!/usr/bin/env python3
"""Checks the language of the documentation, of comments, and of the texts that the program shows.

Usage: plain_language.py [ROOT] [--list] [--write] [PATH...]

Rules:

  long      no sentence has more than 35 words; inline code and a link count as they are read
  opening   no comment starts with "The same", "Likewise" or "As above"
  retired   no retired word: RETIRED has each one with what to write instead
  words     README.md has at most 900 words, a page of docs/decisions 700: what stands between spaces, code and tables too
            (as `wc -w` counts)

It reads README.md, ARCHITECTURE.md, CHANGELOG.md, CONTRIBUTING.md, all Markdown of docs/ and proto/, and the comments
of the headers and sources of core/, proto/ and server/. Code blocks, inline code and names of code are not checked. A row of a
table in a comment, whose columns are two spaces apart, is a sentence of its own.

It also reads the string literals of the sources and headers of core/, proto/ and server/: help, log and error texts.
Literals that follow each other are one text. Literals without two words beside each other are not prose. The strings of
proto/openapi.json and proto/questions.json, the man page, and strings and comments of the Python client and of scripts
(for shell scripts also lines of usage and of messages) are read too.

tests/laws/plain_language_baseline.txt lists the files that still break a rule, each with its number of faults. A file
that is not listed has no fault. The test fails when a number grows; --write lowers the numbers that have shrunk.
--list prints each fault. PATH restricts the check to files whose name begins so.
"""

import io
import re
import sys
import tokenize
from pathlib import Path

LONGEST = 35
PAGES_LONGEST = {"README.md": 900, "docs/decisions/0": 700}
BASELINE = "tests/laws/plain_language_baseline.txt"
OPENING = re.compile(r"(The same|Likewise|As above)\b")

# What is retired, as a regular expression over prose, and what to write instead.
RETIRED = {
    r"doors?|connection gates?": "event loop, acceptor",
    r"flights?": "interleaved traversal, many rays in flight",
    r"crowds?": "masked packet over instances",
    r"windows?": "ray binning",
    r"beams?": "interval culling of a packet",
    r"wedges?": "vertex culling",
    r"together": "batch scheduler; in total; at once",
    r"seen planes": "triangle setup cache",
    r"kept sides": "resolved filter",
    r"pending": "unbuilt subtrees; waiting",
    r"finishers?": "exact rounding of t",
    r"unhittable|unskipped|lone (?:mesh|meshes)": "degenerate triangles; reference import; single-primitive meshes",
    r"short turns|hurry|hurries|hurried|going first": "thread priority, yield",
    r"keepers?": "tree cache manager",
    r"ahead": "in the background; in advance",
    r"keep|keeps|keeping|kept": "retain, cache, store, check, hold",
    r"look|looks|looked|looking": "check, read, search",
    r"who|whom|whoever": "name the client, the thread, the caller",
    r"the one|the ones": "name the thing",
    r"dear|dearer|dearest|dearly": "slow, costly",
}
RETIRED = [(re.compile(rf"\b(?:{words})\b", re.IGNORECASE), instead) for words, instead in RETIRED.items()]
# Proper names and standard terms that contain such a word.
PROPER = re.compile(r"Keep a Changelog|[Kk]eep-[Aa]live|(?:[Rr]ays?|[Rr]equests?) in flight|in-flight|sliding windows?|compression windows?|Windows\b")


class Fault:
    def __init__(self, path, line, rule, text):
        self.path, self.line, self.rule, self.text = path, line, rule, text

    def __str__(self):
        return f"{self.path}:{self.line}: {self.rule}: {self.text}"


def without_code(text):
    """Prose with code replaced by X: one word for each inline code, link target or name of code."""
    text = re.sub(r"``.*?``|`[^`]*`", "X", text)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"https?://\S+|(?<![\w-])--[a-z][a-z-]*", "X", text)
    text = PROPER.sub("X", text)
    # Names of code: with _ or ::, a call, a file, camel case, JSON text.
    text = re.sub(r'"[^"\s]*"', "X", text)
    return re.sub(r"[\w./:<>~-]*(?:\w_\w|::|\w\(\)|\.(?:h|cpp|py|md|sh|json)\b|[a-z]\.[a-z]|[a-z0-9][A-Z])[\w./:<>()*&,-]*", lambda match: "X" + re.search(r"[.,:)]*$", match.group(0)).group(0), text)


SENTENCE_END = re.compile(r"(?<!\be\.g)(?<!\bi\.e)(?<!\bal)(?<!\bvs)(?<!\bcf)(?<!\beq)(?<!\bSec)[.!?][)\"'*]*(?=\s|$)")


def sentences(text):
    start = 0
    for match in SENTENCE_END.finditer(text):
        yield start, text[start:match.end()]
        start = match.end()
    if text[start:].strip():
        yield start, text[start:]


def words(sentence):
    return [word for word in sentence.split() if re.search(r"[^\W_]", word)]


def check_block(path, lines, opening):
    """lines: (number, text) of one paragraph, item, cell or comment."""
    raw = " ".join(text.strip() for _, text in lines)
    if opening and OPENING.match(raw):
        yield Fault(path, lines[0][0], "opening", raw[:60])
    text = without_code(raw)
    for _, sentence in sentences(text):
        count = len(words(sentence))
        if count > LONGEST:
            yield Fault(path, lines[0][0], "long", f"{count} words: {sentence.strip()[:90]}")
    for pattern, instead in RETIRED:
        for match in pattern.finditer(text):
            around = text[max(0, match.start() - 40):match.end() + 30]
            yield Fault(path, lines[0][0], "retired", f'"{match.group(0)}" (say: {instead}): ...{around}...')


def markdown_blocks(text):
    """Paragraphs, items, headings and cells as lists of (number, text)."""
    block, fenced, before_blank = [], False, True
    in_item = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
            if block:
                yield block
            block = []
            continue
        if fenced:
            continue
        if not line.strip():
            if block:
                yield block
            block, before_blank = [], True
            continue
        if line.startswith("    ") and before_blank and not block and not (in_item and re.match(r"\s*([-*]|\d+\.) ", line)):
            continue  # A code block goes on until a line that is not indented.
        before_blank = False
        item = re.match(r"\s*(?:[-*]|\d+\.) (.*)", line)
        if line.startswith("|"):
            if block:
                yield block
            block = []
            if not re.fullmatch(r"[|\s:-]+", line):
                for cell in re.split(r"(?<!\\)\|", line.strip().strip("|")):
                    yield [(number, cell)]
        elif line.startswith("#"):
            if block:
                yield block
            block, in_item = [], False
            yield [(number, line.lstrip("# "))]
        elif item:
            if block:
                yield block
            block, in_item = [(number, item.group(1))], True
        else:
            if not line.startswith(" ") and not block:
                in_item = False
            block.append((number, line))
    if block:
        yield block


STRING_OR_COMMENT = re.compile(r'"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])\'|(//[^\n]*)|(/\*.*?\*/)', re.DOTALL)


def comment_blocks(text):
    """Comments of C++: lines of // that follow each other are one, and so is a comment beside code with its ///< lines."""
    block, last, last_beside, in_item = [], -1, False, False
    for match in STRING_OR_COMMENT.finditer(text):
        comment = match.group(1) or match.group(2)
        if not comment:
            continue
        number = text.count("\n", 0, match.start()) + 1
        beside = text[text.rfind("\n", 0, match.start()) + 1:match.start()].strip() != ""
        lines = [comment] if match.group(1) else comment.strip("/*").splitlines()
        for offset, line in enumerate(lines):
            content = re.sub(r"^\s*(?:///?<?|\*)", "", line)
            content = content[1:] if content.startswith(" ") else content
            if "NOLINT" in content or "clang-format" in content:
                content = ""
            follows = number + offset == last + 1 and not beside and (not last_beside or "///<" in line)
            # An item of a list, or a row of a table: its columns are two spaces apart.
            columns = re.search(r"\S {2,}\S", content)
            item = re.match(r"\s*(?:[-*]|\d+\.) ", content) or (columns and not content.startswith(" "))
            # What is indented is a formula or a diagram, unless it continues an item.
            continues = in_item and follows and not columns
            diagram = content.startswith("  ") and not continues
            diagram = diagram and not item or re.match(r"[|+=<>/\\-]{2}", content.strip())
            if block and (not follows or not content.strip() or diagram or item):
                yield block
                block = []
            last, last_beside = number + offset, beside or (last_beside and follows)
            in_item = bool(item) or (in_item and follows and content.startswith("  "))
            if content.strip() and not diagram:
                block.append((number + offset, re.sub(r"^\s*[-*] ", "", content)))
    if block:
        yield block


LITERAL = r'"(?:\\.|[^"\\\n])*"'
TEXT = re.compile(rf'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|\'(?:\\.|[^\'\\\n])\'|^ *#[^\n]*|({LITERAL}(?:\s*{LITERAL})*)', re.DOTALL | re.MULTILINE)
ESCAPES = {"\\n": "\n", '\\"': '"', "\\\\": "\\"}


def string_blocks(text):
    """String literals that are prose, each with its line; a line of a literal is a sentence of its own."""
    for match in TEXT.finditer(text):
        if not match.group(2):
            continue
        literal = "".join(part[1:-1] for part in re.findall(LITERAL, match.group(2)))
        literal = re.sub(r'\\[n"\\]', lambda escape: ESCAPES[escape.group(0)], literal)
        number = text.count("\n", 0, match.start()) + 1
        for line in literal.split("\n"):
            if re.search(r"[A-Za-z]{2,} [A-Za-z]{2,}", line):
                yield [(number, line)]


PROSE = re.compile(r"[A-Za-z]{2,} [A-Za-z]{2,}")


def text_blocks(text, first):
    """Paragraphs of a docstring or of the comment of a script. Items, rows of columns and requests of troff begin a block."""
    block = []
    for number, line in enumerate(text.split("\n"), first):
        stripped = line.strip()
        if block and (not stripped or re.match(r"[-*|$.] |--|\.[A-Z]|\d\. ", stripped) or re.search(r"\S {2,}\S", stripped)):
            yield block
            block = []
        if stripped:
            block.append((number, stripped))
    if block:
        yield block


def python_blocks(text):
    """Strings and comments that are prose."""
    comments, last = [], -1
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            if comments and token.start[0] == last + 1:
                comments[-1][1].append(token.string.lstrip("#! "))
            else:
                comments.append((token.start[0], [token.string.lstrip("#! ")]))
            last = token.start[0]
        elif token.type == tokenize.STRING:
            body = re.sub(r"""^[A-Za-z]*(\"\"\"|\'\'\'|"|')|(\"\"\"|\'\'\'|"|')$""", "", token.string)
            yield from (block for block in text_blocks(body, token.start[0]) if PROSE.search(block[0][1]))
    for first, lines in comments:
        yield from text_blocks("\n".join(lines), first)


def shell_blocks(text):
    """Comments, strings that are prose, and lines of texts that a script prints."""
    comment, first = [], 0
    for number, line in enumerate([*text.split("\n"), ""], 1):
        match = re.match(r"\s*#(?!!)(.*)", line)
        if match:
            first = first if comment else number
            comment.append("" if match[1].startswith("   ") else match[1])
            continue
        if comment:
            yield from text_blocks("\n".join(comment), first)
        comment = []
        for string in re.findall(r'"((?:\\.|[^"\\])*)"', line) or re.findall(r"^[A-Z][a-z]+ .*", line):
            if PROSE.search(string):
                yield [(number, string)]


def man_blocks(text):
    """The lines of a man page that are no requests. scripts/man_page.py writes a paragraph as one line."""
    block = []
    for number, line in enumerate([*text.split("\n"), "."], 1):
        if not line.startswith("."):
            block.append((number, re.sub(r"\\fB.*?\\fR", "X", line).replace("\\&", "").replace("\\-", "-")))
        elif block:
            yield block
            block = []


def checked_files(root):
    yield from (name for name in ("README.md", "ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md") if (root / name).is_file())
    for folder, pattern in (("docs", "*.md"), ("proto", "*.md"), ("core", "*.h"), ("proto", "*.h"), ("server", "*.h"), ("core", "*.cpp"), ("proto", "*.cpp"), ("server", "*.cpp"),
                            ("docs", "*.1"), ("proto", "*.json"), ("proto", "*.py"), ("scripts", "*.py"), ("scripts", "*.sh")):
        yield from sorted(path.relative_to(root).as_posix() for path in (root / folder).rglob(pattern) if "node_modules" not in path.parts)


def faults_of(root, name):
    text = (root / name).read_text(encoding="utf-8")
    readers = {".h": (comment_blocks, string_blocks), ".cpp": (comment_blocks, string_blocks), ".md": (markdown_blocks,), ".json": (string_blocks,),
               ".py": (python_blocks,), ".sh": (shell_blocks,), ".1": (man_blocks,)}
    for reader in readers[Path(name).suffix]:
        for block in reader(text):
            yield from check_block(name, block, reader is comment_blocks)
    for start, most in PAGES_LONGEST.items():
        if name.startswith(start) and len(text.split()) > most:
            yield Fault(name, 1, "words", f"{len(text.split())} words; at most {most}")


def read_baseline(root):
    file = root / BASELINE
    rows = file.read_text(encoding="utf-8").splitlines() if file.is_file() else []
    return {row.split()[1]: int(row.split()[0]) for row in rows if row and not row.startswith("#")}


def main(arguments):
    flags = {argument for argument in arguments if argument.startswith("--")}
    if flags - {"--list", "--write"}:
        print(__doc__)
        return 2
    given = [argument for argument in arguments if argument not in flags]
    root = Path(given.pop(0) if given else Path(__file__).parents[2]).resolve()
    found = {}
    for name in checked_files(root):
        if not given or any(name.startswith(start) for start in given):
            found[name] = list(faults_of(root, name))
    if "--list" in flags:
        for faults in found.values():
            for fault in faults:
                print(fault)
    counts = {name: len(faults) for name, faults in found.items() if faults}
    print(f"{len(found)} files, {sum(counts.values())} faults in {len(counts)} files")
    if given:
        return 1 if counts else 0
    baseline = read_baseline(root)
    grown = {name: count for name, count in counts.items() if count > baseline.get(name, 0)}
    for name, count in grown.items():
        print(f"{name}: {count} faults, allowed are {baseline.get(name, 0)}:")
        for fault in found[name]:
            print(f"  {fault}")
    shrunk = [name for name, count in baseline.items() if counts.get(name, 0) < count]
    if "--write" in flags and (not grown or not (root / BASELINE).is_file()):
        rows = [f"{count} {name}" for name, count in sorted(counts.items())]
        head = "# Files that still break a rule of plain_language.py, with their number of faults. Numbers only go down.\n"
        (root / BASELINE).write_text(head + "\n".join([*rows, ""]), encoding="utf-8")
        return 0
    for name in shrunk:
        print(f"{name}: {counts.get(name, 0)} faults, {baseline[name]} in {BASELINE}: lower it with --write")
    return 1 if grown else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
