# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
The content of `poses.json` and `trace.json`.

`poses.json` depends on the input and the parameters only: no time, no date, no thread count.
"""

from collections.abc import Mapping
import math
from typing import Any

from ros_rops.core.types import Status
from ros_rops.reporting.run import Run


def poses_document(run: Run) -> dict[str, Any]:
    """
    Return what `poses.json` says.

    Returns
    -------
    dict
        ``units``, ``mesh_resolution`` (in these units), ``objects`` (``id``, ``views`` with
        ``name`` and ``T_object_view``, 4x4 rows), ``views`` (all, in order of arrival: ``name``,
        ``status``, ``object``, ``reason``, ``centroid`` of the points in the view's own frame,
        and the numbers of the verdict), ``attempts``; ``complete``, false, where a part of the
        input was not read; ``station``, what was known of it, found and used, where anything was
        said (parameters `prior.*`).
    """
    session = run.session
    reports = {report.name: report for report in session.reports}
    document: dict[str, Any] = {
        'units': session.units,
        'mesh_resolution': plain(session.mesh_resolution),
        'objects': [
            {
                'id': int(model.id),
                'views': [
                    {'name': view.name, 'T_object_view': plain(view.T_object_view.tolist())}
                    for view in model.views
                ],
            }
            for model in session.objects
        ],
        'views': [
            _refused(name, run.refusals[name].reason) if name in run.refusals
            else _view(reports[name], session) for name in run.order
        ],
        'attempts': int(session.attempts),
    }
    if session.station:
        document['station'] = plain(session.station)
    return document if run.complete else {**document, 'complete': False}


def _refused(name: str, reason: str) -> dict[str, Any]:
    return {'name': name, 'status': Status.REFUSED.value, 'object': None, 'reason': reason}


def _view(report: Any, session: Any) -> dict[str, Any]:
    entry: dict[str, Any] = {
        'name': report.name,
        'status': report.status.value,
        'object': report.object_id,
        'reason': report.reason,
    }
    view = session.views.get(report.name)
    if view is not None and len(view.points):
        entry['centroid'] = plain(view.points.mean(axis=0).tolist())
    return entry | {key: plain(value) for key, value in report.numbers.items() if key not in entry}


def trace_document(run: Run) -> dict[str, Any]:
    """Return what `trace.json` says: every registration attempted, in order."""
    return {'attempts': [_attempt(attempt) for attempt in run.session.trace]}


def _attempt(attempt: Any) -> dict[str, Any]:
    return {
        'source': attempt.source,
        'target': attempt.target,
        'source_views': list(attempt.source_views),
        'target_views': list(attempt.target_views),
        'status': attempt.status.value,
        'reason': attempt.reason,
        'numbers': plain(attempt.numbers),
        'seconds': plain(attempt.seconds),
    }


def plain(value: Any) -> Any:
    """Return `value` in JSON's own types; NaN and infinities as None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if hasattr(value, 'item'):
        value = value.item()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
