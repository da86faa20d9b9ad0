# SPDX-License-Identifier: BSD-3-Clause
"""From a file of a sweep to its runs: every combination of scenarios, robots, controllers, parameters and seeds."""
import copy
import functools
import hashlib
import itertools
import json
import math
import os
import random

from sweep_yaml import BadSweep, SweepYaml

KEYS = {'scenario', 'robots', 'controllers', 'seeds', 'parameters', 'duration'}
MOST_RUNS = 100000  # scenarios of all runs are in memory, about 10 kB each


def load(path):
    sweep = SweepYaml(path)
    for key, value in sweep.values.items():
        sweep.expect(key in KEYS, key, value, 'one of the keys ' + ', '.join(sorted(KEYS)))
    if 'scenario' not in sweep.values:
        raise BadSweep('%s: has no key scenario: expected the name of a scenario file, or a list of them' % path)
    return sweep


def as_list(value):
    return value if isinstance(value, list) else [value]


def is_integer(value):
    return isinstance(value, int) and not isinstance(value, bool)


def is_number(value):
    return is_integer(value) or isinstance(value, float) and math.isfinite(value)


def find_files(sweep, key):
    names = as_list(sweep.values[key])
    sweep.expect(names and all(isinstance(name, str) for name in names), key, sweep.values[key], 'the name of a file, or a list of them')
    return names


def find_mapping(sweep, key):
    """{name: value}; without the key, an empty one."""
    mapping = sweep.values.get(key, {})
    sweep.expect(isinstance(mapping, dict), key, mapping, 'lines NAME: VALUE')
    return mapping


def find_seeds(sweep):
    """A number of seeds, or the seeds; none: the scenario's own."""
    seeds = sweep.values.get('seeds', [None])
    if is_integer(seeds) and 1 <= seeds <= MOST_RUNS:
        return range(1, seeds + 1)
    fits = isinstance(seeds, list) and seeds and (seeds == [None] or all(map(is_integer, seeds)))
    sweep.expect(fits, 'seeds', seeds, 'a number of seeds from 1 to %d, or a list of whole numbers' % MOST_RUNS)
    return seeds


def find_levels(sweep, name, value):
    """Values of a parameter that are combined with all others; a random one is drawn for each run, so it has one level."""
    key = 'parameters.' + name
    sweep.expect(all(name.split('.')), key, value, 'a path of keys, such as ground.friction')
    if isinstance(value, dict) and {'from', 'to', 'count'} == set(value):
        count = value['count']
        sweep.expect(is_integer(count) and 2 <= count <= MOST_RUNS, key, count, 'a count from 2 to %d' % MOST_RUNS)
        sweep.expect(is_number(value['from']) and is_number(value['to']), key, value, 'numbers after from and to')
        return [round(value['from'] + (value['to'] - value['from']) * i / (count - 1), 12) for i in range(count)]
    if isinstance(value, dict):
        numbers = list(value.values())[0] if set(value) in ({'uniform'}, {'normal'}) else None
        sweep.expect(isinstance(numbers, list) and len(numbers) == 2 and all(map(is_number, numbers)), key, value,
                     'a list, {from, to, count}, {uniform: [a, b]} or {normal: [mean, deviation]}')
        return [value]
    sweep.expect(value != [], key, value, 'at least one value')
    return as_list(value)


def draw(name, level, seed):
    """Equal seeds draw equal values, whatever else is swept."""
    if not isinstance(level, dict):
        return level
    (kind, (a, b)), = level.items()
    source = random.Random('%s/%s' % (name, seed))
    return source.uniform(a, b) if kind == 'uniform' else source.gauss(a, b)


def set_path(scenario, path, value):
    *folders, last = path.split('.')
    place = scenario.values
    for depth, folder in enumerate(folders, 1):
        place = place.setdefault(folder, {})
        scenario.expect(isinstance(place, dict), '.'.join(folders[:depth]), place, 'a section, as the sweep sets %s' % path)
    place[last] = value


def resolve(value, folder):
    """Names of files that lie beside the scenario become whole paths: the scenario is run from another place."""
    if isinstance(value, dict):
        return {key: resolve(each, folder) for key, each in value.items()}
    if isinstance(value, list):
        return [resolve(each, folder) for each in value]
    if isinstance(value, str) and os.path.isfile(os.path.join(folder, value)):
        return os.path.abspath(os.path.join(folder, value))
    return value


def merge(old, new):
    """Keys of the new mapping in the place of the old one's, section by section."""
    merged = dict(old)
    for key, value in new.items():
        both = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = merge(merged[key], value) if both else value
    return merged


def read_scenario(path):
    scenario = SweepYaml(path)
    scenario.values = resolve(scenario.values, os.path.dirname(os.path.abspath(path)))
    return scenario


def set_seed(scenario, seed):
    """Of the noise of sensors, and of the random masses and poses."""
    if seed is None:
        return
    scenario.values['seed'] = seed
    if 'variation' in scenario.values:
        set_path(scenario, 'variation.seed', seed)


def set_controller(scenario, changes):
    scenario.expect(isinstance(scenario.values.setdefault('controller', {}), dict), 'controller', scenario.values['controller'],
                    'a section, as the sweep has controllers')
    scenario.values['controller'] = merge(scenario.values['controller'], changes)


def find_controllers(sweep, folder):
    """{name: keys in the place of the scenario's}; none: the scenario's own."""
    controllers = find_mapping(sweep, 'controllers')
    for name, changes in controllers.items():
        sweep.expect(isinstance(changes, dict), 'controllers.' + name, changes, 'keys of the section controller, or {}')
    return resolve(controllers, folder) or {None: None}


def combine(sweep, folder):
    """(names of the parameters, all combinations of scenario, robot, controller, values of the parameters, seed)."""
    scenarios = {name: read_scenario(os.path.join(folder, name)) for name in find_files(sweep, 'scenario')}
    robots = find_files(sweep, 'robots') if 'robots' in sweep.values else [None]
    parameters = find_mapping(sweep, 'parameters')
    levels = [find_levels(sweep, name, value) for name, value in parameters.items()]
    axes = [list(scenarios.items()), robots, list(find_controllers(sweep, folder).items()), *levels, find_seeds(sweep)]
    count = math.prod(map(len, axes))
    if count > MOST_RUNS:
        raise BadSweep('%s: makes %d runs, expected at most %d' % (sweep.path, count, MOST_RUNS))
    return list(parameters), itertools.product(*axes)


def list_named_files(value):
    """Of all whole paths in a scenario: robots, motions, meshes, worlds."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return sorted({name for each in value for name in list_named_files(each)})
    return [value] if isinstance(value, str) and os.path.isabs(value) and os.path.isfile(value) else []


@functools.lru_cache(maxsize=None)
def hash_file(path):
    with open(path, 'rb') as file:
        return hashlib.sha256(file.read()).hexdigest()


def make_key(values, program):
    """Tells runs apart, also in later sweeps: by the scenario, by what is in the files that it names, by the program."""
    files = list_named_files(values) + ([program] if program else [])
    return hashlib.sha256(json.dumps([values, [hash_file(name) for name in files]], sort_keys=True).encode()).hexdigest()[:16]


def make_runs(sweep, path, program=''):
    """[{columns, scenario, key}]: columns describe the run in the table. `program`: the file of what does the runs."""
    folder = os.path.dirname(os.path.abspath(path))
    duration = sweep.values.get('duration')
    sweep.expect(duration is None or is_number(duration), 'duration', duration, 'seconds')
    parameters, combinations = combine(sweep, folder)
    runs = []
    for (name, read), robot, (controller, changes), *values, seed in combinations:
        scenario = copy.deepcopy(read)
        columns = {'scenario': name}
        if robot is not None:
            columns['robot'] = robot
            scenario.values['robot'] = os.path.abspath(os.path.join(folder, robot))
        if controller is not None:
            columns['controller'] = controller
            set_controller(scenario, changes)
        if seed is not None:
            columns['seed'] = seed
        for parameter, level in zip(parameters, values):
            columns[parameter] = draw(parameter, level, seed)
            set_path(scenario, parameter, resolve(columns[parameter], folder))
        set_seed(scenario, seed)
        if duration is not None:
            set_path(scenario, 'steps.duration', duration)
        runs.append({'columns': columns, 'scenario': scenario.values, 'key': make_key(scenario.values, program)})
    return runs
