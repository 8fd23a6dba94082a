"""Where intersections and roads lie, and what they are called."""

from collections.abc import Iterator
from functools import cached_property
from itertools import product

import numpy as np

from engine.frozen import frozen
from engine.maps import RoadSpec
from engine.road.junction import Direction, Junction
from engine.road.regions import Shape, anticlockwise, ring_edges, shape_of, shape_of_parts, triangulate, with_cores
from engine.road.specification import street_wall
from engine.tables import Floats


@frozen
class Site:
    """One intersection's place: centres lie `block` apart, row 0 in the south, column 0 in the west."""

    id: int
    row: int
    col: int
    x: float
    y: float


@frozen
class Grid:
    """The plan of a network: copies of one junction on a grid. The first stands at the origin."""

    spec: RoadSpec

    @cached_property
    def junction(self) -> Junction:
        return Junction(self.spec)

    @cached_property
    def sites(self) -> tuple[Site, ...]:
        block, cols = self.spec.block, self.spec.cols
        places = [(row, col) for row in range(self.spec.rows) for col in range(cols)]
        return tuple(Site(row * cols + col, row, col, col * block, row * block) for row, col in places)

    def arms(self) -> Iterator[tuple[Site, Direction]]:
        return ((site, arm) for site in self.sites for arm in self.junction.arms)

    def neighbour(self, site: Site, arm: Direction) -> int | None:
        """The intersection that an arm leads to, if that one has an arm to meet it."""
        row, col = site.row + arm.row, site.col + arm.col
        if arm.opposite in self.junction.arms and 0 <= row < self.spec.rows and 0 <= col < self.spec.cols:
            return row * self.spec.cols + col
        return None

    def arm_length(self, site: Site, arm: Direction) -> float:
        """From the stop line to the border or to the neighbour's stop line [m]."""
        if self.neighbour(site, arm) is None:
            return self.spec.approach
        return self.spec.block - 2.0 * self.junction.stop

    def site_name(self, site: Site) -> str:
        return "intersection" if len(self.sites) == 1 else f"r{site.row}c{site.col}"

    def name_at(self, site: Site, name: str) -> str:
        """A name that is unique in the network."""
        return name if len(self.sites) == 1 else f"{self.site_name(site)}.{name}"

    def road_name(self, site: Site, arm: Direction) -> str:
        """One name for both directions, whichever end it is asked at."""
        neighbour = self.neighbour(site, arm)
        if neighbour is not None and neighbour < site.id:
            return self.name_at(self.sites[neighbour], arm.opposite.name)
        return self.name_at(site, arm.name)

    # -- the whole road as a region

    def shape(self) -> Shape:
        """All junctions and roads as one region. Where they touch, at the stop lines, there is no boundary."""
        kerbs = self.kerbs()
        boundary = [kerbs + (site.x, site.y) * 2 for site in self.sites]
        tile = triangulate(anticlockwise(self.junction.outline))
        tiles = [tile + (site.x, site.y) * 3 for site in self.sites]
        for site, arm in self.arms():
            ring = self.arm_ring(site, arm)
            is_border = self.neighbour(site, arm) is None
            if is_border or (arm.x, arm.y) in ((1, 0), (0, 1)):  # a road between two junctions counts once
                boundary.append(ring_edges(ring)[[0, 1, 2] if is_border else [0, 2]])
                tiles.append(np.array([[*ring[0], *ring[1], *ring[2]], [*ring[0], *ring[2], *ring[3]]]))
        return with_cores(shape_of_parts(np.vstack(boundary), np.vstack(tiles)), self.bands())

    def bands(self) -> list[tuple[float, float, float, float]]:
        """Rectangles in the road that hold nearly all of it: the west-east roads, and the south-north ones."""
        half, reach = self.junction.half_width, self.junction.stop + self.spec.approach
        last_x, last_y = self.sites[-1].x, self.sites[-1].y
        rows = [(-reach, site.y - half, last_x + reach, site.y + half) for site in self.sites if site.col == 0]
        if self.spec.ways == 4:
            return rows + [
                (site.x - half, -reach, site.x + half, last_y + reach) for site in self.sites if site.row == 0
            ]
        return rows + [(site.x - half, site.y - reach, site.x + half, site.y + half) for site in self.sites]

    def junction_shape(self) -> Shape:
        """The area of a junction around the origin, with the two roads that cross in it."""
        half, stop = self.junction.half_width, self.junction.stop
        top = stop if self.spec.ways == 4 else half
        return with_cores(shape_of(self.junction.outline), [(-stop, -half, stop, half), (-half, -stop, half, top)])

    def kerbs(self) -> Floats:
        """Boundary edges of one junction: its outline without the stop lines."""
        outline = ring_edges(self.junction.outline)
        middle = 0.5 * (outline[:, :2] + outline[:, 2:])
        is_stop = np.zeros(len(outline), dtype=bool)
        for arm in self.junction.arms:
            is_stop |= np.hypot(*(middle - self.junction.stop * np.array([arm.x, arm.y])).T) < 1e-9
        return outline[~is_stop]

    # -- what stands beside it

    def buildings(self) -> Floats:
        """(n, 5): x, y, heading, length, width of blocks, one between each two arms that meet at a corner.

        A block reaches from a street wall to the next one, or to where the roads end.
        """
        if self.spec.buildings is None:
            return np.zeros((0, 5))
        blocks = [block for site in self.sites for block in self._blocks_at(site)]
        return np.array([(site_x, site_y, 0.0, length, width) for site_x, site_y, length, width in blocks])

    def _blocks_at(self, site: Site) -> Iterator[tuple[float, float, float, float]]:
        """Centres and sizes of the blocks at the corners of a site that no other site has told of."""
        spec, wall, end = self.spec, street_wall(self.spec), self.junction.stop + self.spec.approach
        arms = self.junction.arms
        for across, along in product((arm for arm in arms if arm.x), (arm for arm in arms if arm.y)):
            beside, behind = self._continues(site, across), self._continues(site, along)
            if (beside and across.x < 0) or (behind and along.y < 0 and spec.ways == 4):
                continue
            far_x = spec.block - wall if beside else end
            far_y = spec.block - wall if behind else end
            if spec.ways == 3:  # the stem ends before the next row, and the blocks along it with it
                far_y = min(far_y, end)
            x, y = site.x + 0.5 * across.x * (wall + far_x), site.y + 0.5 * along.y * (wall + far_y)
            yield x, y, far_x - wall, far_y - wall

    def _continues(self, site: Site, arm: Direction) -> bool:
        """Whether there is an intersection in the direction of an arm, joined to it or not."""
        return 0 <= site.row + arm.row < self.spec.rows and 0 <= site.col + arm.col < self.spec.cols

    def arm_ring(self, site: Site, arm: Direction) -> Floats:
        """(4, 2) corners of an arm, anticlockwise: the right kerb outwards, across the end, the left kerb back."""
        near, far = self.junction.stop, self.junction.stop + self.arm_length(site, arm)
        ahead, left = np.array([arm.x, arm.y]), self.junction.half_width * np.array([-arm.y, arm.x])
        corners = np.array([near * ahead - left, far * ahead - left, far * ahead + left, near * ahead + left])
        return corners + np.array([site.x, site.y])
