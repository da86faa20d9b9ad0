# SPDX-License-Identifier: BSD-3-Clause
"""From a file of a sweep to its runs: every combination of scenarios, robots, controllers, parameters and seeds."""
import copy
import hashlib
import itertools
import json
import os
import random

import yaml

KEYS = {'scenario', 'robots', 'controllers', 'seeds', 'parameters', 'duration'}


class BadSweep(Exception):
    pass


def load(path):
    try:
        with open(path) as file:
            sweep = yaml.safe_load(file)
    except (OSError, yaml.YAMLError) as error:
        raise BadSweep('%s: %s' % (path, error)) from None
    if not isinstance(sweep, dict) or 'scenario' not in sweep:
        raise BadSweep('%s: a mapping with the key scenario is expected' % path)
    unknown = set(sweep) - KEYS
    if unknown:
        raise BadSweep('%s: unknown key %s; there are %s' % (path, ', '.join(sorted(unknown)), ', '.join(sorted(KEYS))))
    return sweep


def as_list(value):
    return value if isinstance(value, list) else [value]


def find_seeds(sweep):
    """A number of seeds, or the seeds; none: the scenario's own."""
    seeds = sweep.get('seeds', [None])
    return list(range(1, seeds + 1)) if isinstance(seeds, int) else seeds


def find_levels(name, value):
    """Values of a parameter that are combined with all others; a random one is drawn for each run, so it has one level."""
    if isinstance(value, dict) and {'from', 'to', 'count'} == set(value):
        count = value['count']
        if count < 2:
            raise BadSweep('parameters.%s.count: at least 2' % name)
        return [round(value['from'] + (value['to'] - value['from']) * i / (count - 1), 12) for i in range(count)]
    if isinstance(value, dict) and (set(value) == {'uniform'} or set(value) == {'normal'}):
        return [value]
    if isinstance(value, dict):
        raise BadSweep('parameters.%s: a list, {from, to, count}, {uniform: [a, b]} or {normal: [mean, deviation]}' % name)
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
    place = scenario
    for folder in folders:
        place = place.setdefault(folder, {})
        if not isinstance(place, dict):
            raise BadSweep('parameters.%s: %s is no section of the scenario' % (path, folder))
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
    try:
        with open(path) as file:
            return resolve(yaml.safe_load(file), os.path.dirname(os.path.abspath(path)))
    except (OSError, yaml.YAMLError) as error:
        raise BadSweep('%s: %s' % (path, error)) from None


def set_seed(scenario, seed):
    """Of the noise of sensors, and of the random masses and poses."""
    if seed is None:
        return
    scenario['seed'] = seed
    if 'variation' in scenario:
        scenario['variation']['seed'] = seed


def make_runs(sweep, path):
    """[{columns, scenario, key}]: columns describe the run in the table, the key tells runs apart, also in later sweeps."""
    folder = os.path.dirname(os.path.abspath(path))
    scenarios = {name: read_scenario(os.path.join(folder, name)) for name in as_list(sweep['scenario'])}
    robots = as_list(sweep.get('robots', [None]))
    controllers = sweep.get('controllers', {None: None})
    parameters = sweep.get('parameters', {})
    levels = [find_levels(name, value) for name, value in parameters.items()]
    runs = []
    for name, robot, controller, *values, seed in itertools.product(scenarios, robots, controllers, *levels, find_seeds(sweep)):
        scenario = copy.deepcopy(scenarios[name])
        columns = {'scenario': name}
        if robot is not None:
            columns['robot'] = robot
            scenario['robot'] = os.path.abspath(os.path.join(folder, robot))
        if controller is not None:
            columns['controller'] = controller
            scenario['controller'] = merge(scenario.get('controller', {}), resolve(controllers[controller], folder))
        if seed is not None:
            columns['seed'] = seed
        for parameter, level in zip(parameters, values):
            columns[parameter] = draw(parameter, level, seed)
            set_path(scenario, parameter, columns[parameter])
        set_seed(scenario, seed)
        if 'duration' in sweep:
            set_path(scenario, 'steps.duration', sweep['duration'])
        key = hashlib.sha256(json.dumps(scenario, sort_keys=True).encode()).hexdigest()[:16]
        runs.append({'columns': columns, 'scenario': scenario, 'key': key})
    return runs
