#!/usr/bin/env python3
"""The language check under test: small texts, each with one fault, and texts that only resemble one."""

import tempfile
import unittest
from pathlib import Path

import plain_language


def faults(text, header=False):
    blocks = plain_language.comment_blocks(text) if header else plain_language.markdown_blocks(text)
    return [fault.rule for block in blocks for fault in plain_language.check_block("x", block, header)]


class PlainLanguage(unittest.TestCase):
    def test_a_sentence_of_35_words_passes_and_one_of_36_fails(self):
        self.assertEqual(faults("word " * 34 + "end. Another one.\n"), [])
        self.assertEqual(faults("word " * 18 + "\n" + "word " * 17 + "end.\n"), ["long"])
        self.assertEqual(faults("/// " + "word " * 18 + "\n/// " + "word " * 17 + "end.\n", header=True), ["long"])

    def test_items_cells_and_headings_are_sentences_of_their_own(self):
        self.assertEqual(faults("- " + "word " * 20 + "\n- " + "word " * 20 + "\n"), [])
        self.assertEqual(faults("| " + "word " * 20 + "| " + "word " * 20 + "|\n"), [])
        self.assertEqual(faults("# " + "word " * 20 + "\n\n" + "word " * 20 + "\n"), [])

    def test_code_is_not_read(self):
        self.assertEqual(faults("    the door " + "word " * 40 + "\n"), [])
        self.assertEqual(faults("Text.\n\n    the door\n\n    more of the door\n"), [])
        self.assertEqual(faults("```\nthe door\n```\n`door` [a](door.md) door_flags.h\n"), [])
        self.assertEqual(faults('int door = 1; const char* text = "// the door";\n///     door -> door\n', header=True), [])

    def test_a_retired_word_fails_in_any_form(self):
        for text in ("The door opens.", "Whoever asks.", "Kept for later.", "the one that is met"):
            self.assertEqual(faults(text + "\n"), ["retired"], text)
            self.assertEqual(faults(f"int x;  ///< {text}\n", header=True), ["retired"], text)
        self.assertEqual(faults("Keep-Alive and many rays in flight; indoor; the whole.\n"), [])

    def test_a_comment_does_not_begin_with_a_reference_to_another(self):
        for start in ("The same for boxes.", "Likewise.", "As above, in float32."):
            self.assertEqual(faults(f"/// {start}\n", header=True), ["opening"], start)
            self.assertEqual(faults(f"{start}\n"), [])
        self.assertEqual(faults("/// Both have\n/// The same bytes.\n", header=True), [])

    def test_texts_of_the_program_are_read(self):
        def of(text):
            return [(fault.line, fault.rule) for block in plain_language.string_blocks(text) for fault in plain_language.check_block("x", block, False)]

        self.assertEqual(of('a;  // a door\nsay("the "\n    "door is shut");\n'), [(2, "retired")])
        self.assertEqual(of('say("' + "word " * 20 + '"\n    "' + "word " * 20 + '");\n'), [(1, "long")])
        self.assertEqual(of('say("' + "word " * 20 + "\\n" + "word " * 20 + '");\n'), [])
        self.assertEqual(of('// "the door"\n#include "the door"\nR"(the door)"; "door"; \'"\'; x; "a \\"b\\" c";\n'), [])

    def test_scripts_and_the_client_and_the_man_page_are_read(self):
        def of(reader, text):
            return [(fault.line, fault.rule) for block in reader(text) for fault in plain_language.check_block("x", block, False)]

        self.assertEqual(of(plain_language.python_blocks, 'def door():\n    """Shuts\n\n    the door."""\n    say("door")  # the door\n'),
                         [(4, "retired"), (5, "retired")])
        self.assertEqual(of(plain_language.shell_blocks, '#!/bin/sh\n# The door.\n#     the door\ndoor=1\necho "the door"\nOpen the door.\n'),
                         [(2, "retired"), (5, "retired"), (6, "retired")])
        self.assertEqual(of(plain_language.man_blocks, ".TP\n\\fB\\-\\-door\\fR\nShuts it.\n.TP\nthe door\n"), [(5, "retired")])

    def test_the_readme_has_at_most_900_words_and_a_decision_700(self):
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "docs/decisions").mkdir(parents=True)
            for name, most in (("README.md", 900), ("docs/decisions/0001-a.md", 700)):
                for words, found in ((most, []), (most + 1, ["words"])):
                    Path(folder, name).write_text("Word. " * words, encoding="utf-8")
                    self.assertEqual([fault.rule for fault in plain_language.faults_of(Path(folder), name)], found)


if __name__ == "__main__":
    unittest.main()
