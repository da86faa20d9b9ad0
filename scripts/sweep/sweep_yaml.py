# SPDX-License-Identifier: BSD-3-Clause
"""YAML files of a sweep as people write them: what cannot be meant is refused with file, line and key."""
import re

import yaml

TAG = 'tag:yaml.org,2002:'
MERGE = TAG + 'merge'  # the key <<
DATE = TAG + 'timestamp'
PLAIN = {TAG + kind for kind in ('null', 'bool', 'int', 'float', 'str', 'seq', 'map')}  # what a scenario can hold


class BadSweep(Exception):
    pass


class Loader(yaml.SafeLoader):
    """Keys are the words that stand there, once each; an alias does not hold itself."""

    def __init__(self, stream):
        super().__init__(stream)
        self.deep_construct = True  # else PyYAML builds lists that hold themselves

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise yaml.constructor.ConstructorError(None, None, 'a key is no word', key.start_mark)
            if key.value in seen and key.tag != MERGE:
                raise yaml.constructor.ConstructorError(None, None, "the key '%s' is there twice" % key.value, key.start_mark)
            seen.add(key.value)
        self.flatten_mapping(node)
        return {key.value: self.construct_object(value, deep=True) for key, value in node.value}


Loader.yaml_constructors = {tag: make for tag, make in Loader.yaml_constructors.items() if tag is None or tag in PLAIN}
# A date is text for a scenario, and 1e-3 is a number.
Loader.yaml_implicit_resolvers = {first: [pair for pair in pairs if pair[0] != DATE]
                                  for first, pairs in Loader.yaml_implicit_resolvers.items()}
Loader.add_implicit_resolver(TAG + 'float', re.compile(r'^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$'), list('-+.0123456789'))


def find_fault(error):
    """':line:column: what is wrong', as far as an error of a reader says it."""
    mark = getattr(error, 'problem_mark', None)
    place = ':%d:%d' % (mark.line + 1, mark.column + 1) if mark else ''
    if isinstance(error, RecursionError):
        return ': is nested too deeply'
    if isinstance(error, UnicodeDecodeError):
        return ': is no UTF-8 text: byte %d is 0x%02x' % (error.start, error.object[error.start])
    if isinstance(error, OSError):
        return ': ' + error.strerror
    return '%s: %s' % (place, getattr(error, 'problem', None) or str(error).replace('\n', ' '))


def find_lines(node):
    """Lines of the keys and of the keys below them: {'seeds': 3, 'parameters.ground.friction': 5}."""
    lines = {}
    for key, value in node.value if isinstance(node, yaml.MappingNode) else []:
        lines[key.value] = key.start_mark.line + 1
        for inner, _ in value.value if isinstance(value, yaml.MappingNode) else []:
            lines['%s.%s' % (key.value, inner.value)] = inner.start_mark.line + 1
    return lines


class SweepYaml:
    """A mapping in a file: values by key, and refusals that name the line of a key."""

    def __init__(self, path):
        self.path = path
        try:
            with open(path, encoding='utf-8') as file:
                text = file.read()
            self.values, self.lines = yaml.load(text, Loader), find_lines(yaml.compose(text))
        except (OSError, UnicodeDecodeError, RecursionError, ValueError, yaml.YAMLError) as error:
            raise BadSweep(path + find_fault(error)) from None
        if not isinstance(self.values, dict):
            raise BadSweep('%s: is no mapping: expected lines KEY: VALUE' % path)

    def refuse(self, key, value, expected):
        line = self.lines.get(key)
        raise BadSweep('%s:%s %s: is %s, expected %s' % (self.path, '%d:' % line if line else '', key, show(value), expected))

    def expect(self, fits, key, value, expected):
        if not fits:
            self.refuse(key, value, expected)


def show(value):
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + '...'
