# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""Files of results by hand, as `rops bench` writes them, for what compares them."""

import json

MACHINE = {
    'cpu': 'a', 'cores': 2, 'reference_seconds': [0.0099, 0.01, 0.01, 0.0101, 0.01],
    'reference_cpu_seconds': [0.01, 0.01, 0.01]}


def pair(number, **changes):
    """Return a pair as `rops bench pairwise` tells it, accepted and right."""
    return {
        'source': f's{number}', 'target': f't{number}', 'overlap': 0.5, 'status': 'placed',
        'reason': '', 'correct': True, 'seconds': 0.1 * (1 + 0.05 * (number % 3)),
        'errors': {'rotation_deg': 0.2, 'translation_dres': 0.3}, 'numbers': {'score': 0.4},
        **changes}


def pairs_case(pairs, **changes):
    """Return a case of `rops bench pairwise`."""
    wrong = [
        [one['source'], one['target']] for one in pairs
        if one['status'] == 'placed' and not one['correct']]
    correct = sum(one['correct'] for one in pairs)
    return {
        'case': 'pairwise', 'dataset': 'one', 'by': 'ros_rops', 'mode': 'default', 'seed': 0,
        'pairs': len(pairs), 'pairs_all': len(pairs), 'correct': correct,
        'recall': correct / len(pairs), 'wrong_accepted': wrong, 'details': list(pairs),
        **changes}


def session_case(order='seed 0', **changes):
    """Return a case of `rops bench multiview`."""
    return {
        'case': 'multiview', 'by': 'ros_rops', 'datasets': ['one', 'other'], 'order': order,
        'views': 10, 'placed': 10, 'wrong_placements': 0, 'wrong_merges': 0, 'splits': 0,
        'attempts': 9, 'seconds': 3.0, 'peak_rss_mib': 200.0, 'max_rotation_deg': 0.3,
        'objects': [{'label': 'one', 'placed': 10, 'residual_dres': 0.2}],
        'wrong_views': [], 'errors': {'v0': {'rotation_deg': 0.1}}, 'sequence': ['v0'], **changes}


def write(path, cases, machine=MACHINE, **extra):
    """Write a file of results; returns its path."""
    path.write_text(json.dumps({'machine': machine, 'cases': cases, **extra}), encoding='utf-8')
    return path
