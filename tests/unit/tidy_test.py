#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""tidy_test.py: scripts/tidy.sh looks at what it is asked for, once, and says what it found."""
import concurrent.futures
import contextlib
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / 'scripts/robustness'))
import tidy  # noqa: E402
import tidy_units  # noqa: E402

# Stands for clang-tidy: complains of sources with the word "wrong", and counts how often it is called.
CLANG_TIDY = '''#!/bin/sh
for source; do :; done
echo x >> "{0}/calls"
echo "17 warnings generated." >&2
if grep -q killed "$source"; then exit 130; fi
if grep -q guess "$source"; then echo "/usr/include/eigen3/Eigen/Core:1:2: error: a guess [x]"; bad=1; fi
if grep -q wrong "$source"; then echo "$source:1:2: error: wrong [bugprone-x]"; bad=1; fi
exit ${{bad:-0}}
'''
FILES = {'common/base/a.cpp': '#include "common/base/a.h"\n', 'common/base/a.h': '', 'servers/b.cpp': '#include "common/base/a.h"\n',
         'servers/c.cpp': '#include <cmath>\n', '.clang-tidy': 'Checks: x\n'}


class Tidy(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name).resolve()
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.root)
        for name, text in FILES.items():
            self.write(name, text)
        commands = [{'file': str(self.root / name)} for name in FILES if name.endswith('.cpp')] + [{'file': '/usr/src/elsewhere.cpp'}]
        self.write('build/compile_commands.json', json.dumps(commands))
        self.write('bin/clang-tidy', CLANG_TIDY.format(self.root))
        (self.root / 'bin/clang-tidy').chmod(0o755)
        for patch in (unittest.mock.patch.object(tidy, 'ROOT', self.root),
                      unittest.mock.patch.dict(os.environ, PATH=f'{self.root}/bin:{os.environ["PATH"]}')):
            patch.start()
            self.addCleanup(patch.stop)

    def write(self, name, text):
        (self.root / name).parent.mkdir(parents=True, exist_ok=True)
        (self.root / name).write_text(text)

    def tidy(self, *words):
        """(status, what it prints, how many sources clang-tidy looked at)"""
        (self.root / 'calls').write_text('')
        said = io.StringIO()
        with unittest.mock.patch.object(sys, 'argv', ['tidy.py', str(self.root / 'build'), *words]), contextlib.redirect_stdout(said):
            status = tidy.main()
        return status, said.getvalue(), len((self.root / 'calls').read_text().split())

    def commit(self):
        def git(*words):
            subprocess.run(['git', '-C', str(self.root), '-c', 'user.name=a', '-c', 'user.email=a@b', *words], check=True, capture_output=True)
        self.write('.gitignore', '/build/\n/bin/\n/calls\n')
        git('init', '-q', '-b', 'main')
        git('add', '.')
        git('commit', '-q', '-m', 'all')

    def test_a_clean_tree_is_a_table_and_nothing_else(self):
        status, said, looked = self.tidy('--all')
        self.assertEqual((status, looked), (0, 3))
        self.assertEqual(said, '| folder | sources | with findings |\n|---|---|---|\n| common | 1 | 0 |\n| servers | 2 | 0 |\n')

    def test_a_finding_is_printed_and_counted(self):
        self.write('servers/c.cpp', 'wrong\n')
        status, said, _ = self.tidy('--all')
        self.assertEqual(status, 1)
        self.assertIn('c.cpp:1:2: error: wrong [bugprone-x]', said)
        self.assertIn('| servers | 2 | 1 |', said)
        self.assertNotIn('17 warnings', said)

    def test_what_was_clean_is_looked_at_again_when_its_header_or_a_check_changes(self):
        self.tidy('--all')
        self.assertEqual(self.tidy('--all')[2], 0)
        self.write('servers/c.cpp', '// new\n')
        self.assertEqual(self.tidy('--all')[2], 1)
        self.write('common/base/deep.h', '')
        self.write('common/base/a.h', '#include "common/base/deep.h"\n')
        self.assertEqual(self.tidy('--all')[2], 2)  # c.cpp includes no header of ours
        self.write('common/base/deep.h', '// new\n')
        self.assertEqual(self.tidy('--all')[2], 2)
        self.write('.clang-tidy', 'Checks: y\n')
        self.assertEqual(self.tidy('--all')[2], 3)

    def test_a_finding_stays_one_until_it_is_mended(self):
        self.write('servers/c.cpp', 'wrong\n')
        self.tidy('--all')
        self.assertEqual(self.tidy('--all')[0], 1)

    def test_what_the_analyser_says_of_eigen_is_no_finding(self):
        self.write('servers/c.cpp', 'guess\n')
        self.assertEqual(self.tidy('--all')[0], 0)
        self.write('servers/b.cpp', 'guess and wrong\n')
        status, said, _ = self.tidy('--all')
        self.assertEqual(status, 1)
        self.assertIn('b.cpp:1:2: error: wrong', said)
        self.assertNotIn('a guess', said)

    def test_a_look_that_was_broken_off_is_no_clean_one(self):
        self.write('servers/c.cpp', 'killed\n')
        status, said, _ = self.tidy('--all')
        self.assertEqual(status, 1)
        self.assertIn('c.cpp: clang-tidy ended with status 130', said)

    def test_names_are_folders_or_files(self):
        self.assertEqual(self.tidy('servers')[2], 2)
        self.assertEqual(self.tidy('--jobs', '1', 'common/base/a.cpp')[2], 1)
        with self.assertRaisesRegex(SystemExit, 'nothing of what lies there'):
            self.tidy('.clang-tidy')

    def test_without_names_what_differs_from_main(self):
        self.commit()
        self.assertEqual(self.tidy()[2], 0)
        self.write('servers/c.cpp', '// new\n')
        self.assertEqual(self.tidy()[2], 1)
        self.write('common/base/a.h', '// new\n')
        self.assertEqual(self.tidy()[2], 2)  # c.cpp was clean

    def test_where_nobody_knows_what_changed_it_asks_for_names(self):
        with unittest.mock.patch.dict(os.environ, GIT_CEILING_DIRECTORIES=str(self.root.parent)):
            with self.assertRaisesRegex(SystemExit, 'say --all or names'):
                self.tidy()


# Complains of a unit with more than one source of the name "clash".
CLANG_TIDY_OF_UNITS = '''#!/bin/sh
for unit; do if [ "$unit" = "--" ]; then break; fi; file="$unit"; done
echo x >> "{0}/calls"
if [ "$(grep -c 'include.*clash' "$file")" -gt 1 ]; then echo "clash.cpp:1:2: error: redefinition [clang-diagnostic-error]"; exit 1; fi
'''


class Units(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name).resolve()

    def write(self, **texts):
        for name, text in texts.items():
            (self.root / f'{name}.cpp').write_text(text)
        return [self.root / f'{name}.cpp' for name in texts]

    def test_a_source_is_apart_from_one_that_uses_what_it_defines(self):
        a, b, c = self.write(a='namespace {\nint find(int x) { return x; }\n}\n', b='int two() { return find(2); }\n',
                             c='int three() { return x.find(3); }  // a member, and find() in a comment\n')
        self.assertEqual(tidy_units.make_units([a, b, c], {a: [], b: [], c: []}), [[a, c], [b]])

    def test_a_unit_has_sources_with_the_same_macros_only(self):
        a, b = self.write(a='int a();\n', b='int b();\n')
        self.assertEqual(tidy_units.make_units([a, b], {a: [('-DX',)], b: [('-O3',)]}), [[a], [b]])

    def test_a_unit_that_cannot_be_compiled_is_halved(self):
        tool = self.root / 'clang-tidy'
        tool.write_text(CLANG_TIDY_OF_UNITS.format(self.root))
        tool.chmod(0o755)
        sources = self.write(clash_a='', b='', c='', clash_d='')
        with unittest.mock.patch.dict(os.environ, PATH=f'{self.root}:{os.environ["PATH"]}'):
            said = tidy_units.look(sources, self.root, {source: [('-O3',)] for source in sources})
        self.assertEqual((said, len((self.root / 'calls').read_text().split())), ('', 3))

    def test_calls_side_by_side_look_at_their_own_units(self):
        tool = self.root / 'clang-tidy'
        # Waits until both are there, then says what its unit includes.
        tool.write_text(CLANG_TIDY_OF_UNITS.split('echo')[0] +
                        f'echo x >> "{self.root}/calls"\nwhile [ "$(grep -c x "{self.root}/calls")" -lt 2 ]; do sleep 0.01; done\n'
                        'grep include "$file"\nexit 1\n')
        tool.chmod(0o755)
        sources = self.write(a='', b='')
        with unittest.mock.patch.dict(os.environ, PATH=f'{self.root}:{os.environ["PATH"]}'):
            with concurrent.futures.ThreadPoolExecutor(2) as pool:
                said = list(pool.map(lambda source: tidy_units.look([source], self.root, {source: []}), sources))
        self.assertEqual(said, [f'#include "{source}"\n' for source in sources])

    def test_a_unit_that_was_broken_off_is_no_clean_one(self):
        tool = self.root / 'clang-tidy'
        tool.write_text('#!/bin/sh\nexit 130\n')
        tool.chmod(0o755)
        sources = self.write(a='', b='')
        with unittest.mock.patch.dict(os.environ, PATH=f'{self.root}:{os.environ["PATH"]}'):
            said = tidy_units.look(sources, self.root, {source: [] for source in sources})
        self.assertIn('clang-tidy ended with status 130', said)


if __name__ == '__main__':
    unittest.main()
