# Copyright 2026 The ros_rops authors
# SPDX-License-Identifier: Apache-2.0
"""
What the node publishes.

| topic | what |
|---|---|
| `assembled` | PointCloud2, latched: all objects, each where it was seen last, in the frame of |
| | the sensor that took the newest view (or prior.fixed_frame) |
| `objects/object_<k>/assembled` | the same of one object, latched, in the frame object_<k> |
| `transforms` | TFMessage, latched: object_<k> to view_<n>, for each placed view |
| `/tf` | TFMessage: the sensor's frame (or prior.fixed_frame) to object_<k>, again and again |
| `markers` | MarkerArray, latched: the whole scene each time, in the frame of `assembled` |
| `view_reports` | DiagnosticStatus: the word on a view when it changes, and on bad frames |
| `handled` | Header: of each message that has its word |
| `/diagnostics` | DiagnosticArray: input, queue, registration, journal |

Clouds and markers have stamp 0, for which TF takes the newest transform: what they show holds
until the next ones, and who comes late finds the transforms of their times no more.
"""

from collections.abc import Mapping, Sequence
import threading

from geometry_msgs.msg import Point
from msg_adapters import markers
from rclpy.node import Node
from ros_rops.core.groups_node import PublishConfig
from ros_rops.core.node_config import NodeConfig
from ros_rops.live.health import Inlet
from ros_rops.live.places import FrameNames, last_places, newest_frame, Place, places_in
from ros_rops.live.scene import scene
from ros_rops.live.words import Handled, StationState, Update
from ros_rops.nodes.clouds_out import CloudsOut
from ros_rops.nodes.reports_out import ReportsOut
from ros_rops.nodes.transforms_out import TransformsOut
from ros_rops.nodes.wire import Wire
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray


class Outputs:
    """
    Publish the station's words (`live.words.Listener`) and the node's health.

    Every method may be called from any thread.

    Parameters
    ----------
    node : Node
    config : NodeConfig
    fixed_frame : str
        The parameter prior.fixed_frame.
    """

    def __init__(self, node: Node, config: NodeConfig, *, fixed_frame: str = '') -> None:
        self._node, self._config = node, config.publish
        self._names = FrameNames(frame_prefix(node, config.publish), fixed_frame)
        self._wire = Wire(node)
        # One update at a time; words and health need not wait for it.
        self._lock = threading.Lock()
        self._frame_id = ''
        self._left_out: set[int] = set()
        self._clouds = CloudsOut(self._wire, config.publish, self._names)
        self._transforms = TransformsOut(
            node, self._wire, self._names, broadcast=config.publish.tf)
        self._reports = ReportsOut(
            node, self._wire, self._names, skipped=config.publish.skipped)
        self._markers = (
            self._wire.publisher(MarkerArray, 'markers') if config.publish.markers else None)

    def updated(self, update: Update) -> None:
        """Publish the session's new state."""
        with self._lock:
            self._frame_id = newest_frame(update, self._names) or self._frame_id
            if not self._frame_id:
                return  # nothing was ever shown, nothing is to be shown
            header = Header(frame_id=self._frame_id)
            self._reports.publish(update)
            places = places_in(update, self._names, self._frame_id)
            self._transforms.publish(update, last_places(update, self._names))
            self._clouds.publish(update, places, header)
            self._publish_markers(update, places, header)
            self._say_left_out(update, places)

    def handled(self, handled: Handled) -> None:
        """Publish the word on a message."""
        self._reports.handled(handled)

    def diagnostics(
        self, state: StationState, lifecycle: str,
        extra: Mapping[str, str | float] | None = None, inlets: Sequence[Inlet] = (),
    ) -> None:
        """
        Publish how the node stands; to be called every second.

        Parameters
        ----------
        state : StationState
        lifecycle : str
            'unconfigured', 'inactive', 'active' or 'finalized'.
        extra : mapping of str to str, int or float, optional
            More that is to be said of the input.
        inlets : sequence of Inlet
            The topics that the node listens to, and what is wrong with them.
        """
        self._reports.diagnostics(state, lifecycle, inlets, extra or {})

    def reconfigure(self, config: NodeConfig) -> None:
        """Take over what may change meanwhile: publish.skipped."""
        self._reports.tell_skipped(config.publish.skipped)

    def rebroadcast(self) -> None:
        """Say on /tf again where objects are; to be called publish.tf_rate_hz times a second."""
        self._transforms.rebroadcast()

    def close(self) -> None:
        """Take all publishers away; what comes later is not published."""
        with self._lock:
            self._wire.close()

    def _publish_markers(self, update: Update, places: Sequence[Place], header: Header) -> None:
        if self._markers is not None:
            message = MarkerArray()
            marks = scene(update, places, self._names, self._frame_id)
            markers.fill(message, Marker, Point, ColorRGBA, header, marks)
            self._wire.send(self._markers, message)

    def _say_left_out(self, update: Update, places: Sequence[Place]) -> None:
        missing = {model.id for model in update.objects} - {place.object_id for place in places}
        for object_id in sorted(missing - self._left_out):
            self._node.get_logger().warning(
                f'object {object_id} is left out of `assembled`: nothing says where it stands in '
                f'{self._frame_id}, since another sensor saw it (see prior.fixed_frame)')
        self._left_out |= missing


def frame_prefix(node: Node, config: PublishConfig) -> str:
    """Return what stands before frame names: as configured, else the node's namespace and '/'."""
    if config.frame_prefix:
        return config.frame_prefix
    namespace = node.get_namespace().strip('/')
    return f'{namespace}/' if namespace else ''
