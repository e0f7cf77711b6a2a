use super::layout::Layout;
use super::mesh::{Mesh, Quad, Vertex};
use super::{ClothError, ClothSpec, System};
use crate::geometry::{Frame, Vec3};
use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::{Bvh, BvhNode};
use nalgebra::Point3;
use std::ops::ControlFlow;

/// A facet takes some 700 bytes with its share of the hierarchy.
const MAX_FACETS: usize = 2_000_000;

/// A ray in the cloth's plane may run for ever through a channel of the weave. After this many cells it counts as
/// escaped; at 89.99° to the normal a ray crosses only some thousands.
const MAX_CELLS: usize = 1 << 20;

/// Width, as a fraction of the cell, of the seam in which neighbouring cells both hold a facet. Covers rounding.
const SEAM: f64 = 1e-9;

/// Widening of the boxes as a fraction of the cell's extent, more than what single precision can lose in a box test
/// inside the cell: four roundings of 6e-8.
const BOX_MARGIN: f64 = 5e-7;

/// In place of a yarn's number: facets of several, and none at all.
const SEVERAL_YARNS: u32 = u32::MAX;
const NO_YARN: u32 = u32::MAX - 1;

/// One physical yarn of the endless cloth. A yarn is the same all along itself; its copy one cell sideways is another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct YarnId {
    pub system: System,
    /// Place in the cell.
    pub index: u32,
    /// Cell across the yarn: along y for a warp, along x for a weft.
    pub lateral: i64,
}

/// Where a ray meets the cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// On the facet, mm.
    pub position: Vec3,
    /// In units of the direction's length.
    pub distance: f64,
    /// Of the smooth yarn: axis along the centre line's tangent, normal outwards. The facet may face a grazing ray
    /// while this normal looks slightly away from it.
    pub frame: Frame,
    pub yarn: YarnId,
}

impl Hit {
    pub fn system(&self) -> System {
        self.yarn.system
    }
}

/// A facet as stored in the cell: the yarn's `lateral` is relative to the cell.
struct Facet {
    corners: [Vec3; 4],
    vertices: [u32; 4],
    yarn: YarnId,
}

/// Node of the hierarchy in depth-first order: a ray that meets the box goes on at the next node, any other at `skip`.
/// Boxes are in single precision, widened by [`BOX_MARGIN`]: half the memory to walk through.
struct Node {
    /// Planes of the box that a ray of the node's octant meets first, and last.
    near: [f32; 3],
    far: [f32; 3],
    skip: u32,
    /// `u32::MAX` in an inner node.
    facet: u32,
    /// Place in [`Cloth::yarns`] of the one yarn whose facets are below, or `u32::MAX` for several.
    yarn: u32,
}

/// Tube surface of an endless woven cloth.
pub struct Cloth {
    cell_mm: [f64; 2],
    top_mm: f64,
    /// Heights between which the facets lie.
    slab_mm: [f64; 2],
    vertices: Vec<Vertex>,
    facets: Vec<Facet>,
    /// Yarns of the cell, sorted.
    yarns: Vec<YarnId>,
    /// The hierarchy, once for each octant of directions: [`octant`] of a ray picks the order that meets near facets
    /// first, so that their distances prune the rest.
    orders: [Vec<Node>; 8],
}

impl Cloth {
    /// Errors: a value out of range, a jammed weave, yarns that overlap or bend tighter than they are thick.
    pub fn new(spec: &ClothSpec) -> Result<Self, ClothError> {
        spec.check_ranges()?;
        let draft = spec.weave.draft();
        let repeats = spec.repeats[0] * spec.repeats[1];
        let crossings = draft.yarns(System::Warp) * draft.yarns(System::Weft) * repeats;
        let facets = 2 * crossings * spec.segments_around * spec.segments_along;
        if facets > MAX_FACETS {
            return Err(ClothError::TooManyFacets {
                found: facets,
                limit: MAX_FACETS,
            });
        }
        let layout = Layout::new(spec)?;
        let mesh = Mesh::new(spec, &layout);
        let (cell_mm, top_mm) = (layout.cell_mm, layout.top_mm());
        let facets = facets_of_cell(&mesh, cell_mm);
        let mut yarns: Vec<YarnId> = facets.iter().map(|facet| facet.yarn).collect();
        yarns.sort_unstable();
        yarns.dedup();
        let orders = hierarchy(&facets, &yarns);
        let slab_mm = mesh
            .vertices
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                [low.min(v.position.z), high.max(v.position.z)]
            });
        Ok(Self {
            cell_mm,
            top_mm,
            slab_mm,
            vertices: mesh.vertices,
            facets,
            yarns,
            orders,
        })
    }

    /// Size of one repeat along x and y.
    pub fn cell_mm(&self) -> [f64; 2] {
        self.cell_mm
    }

    /// Height of the highest points of the yarns over the middle plane; the lowest lie as far under it.
    pub fn top_mm(&self) -> f64 {
        self.top_mm
    }

    /// First point of the cloth on a ray that starts outside the yarns. `direction` need not be of unit length.
    pub fn intersect(&self, origin: &Vec3, direction: &Vec3) -> Option<Hit> {
        let mut found = None;
        self.walk(origin, direction, |ray, cell, limit| {
            let mut nearest = limit;
            self.traverse(ray, None, &mut nearest, |facet, meeting, nearest| {
                *nearest = meeting.distance;
                found = Some((facet, meeting, cell));
                ControlFlow::Continue(())
            });
            if found.is_some() {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        let (facet, meeting, cell): (&Facet, Meeting, Cell) = found?;
        let [a, b, c] = meeting.corners.map(|k| &self.vertices[facet.vertices[k] as usize]);
        let [wb, wc] = meeting.weights;
        let wa = 1.0 - wb - wc;
        let frame = Frame::from_axis_normal(
            a.axis * wa + b.axis * wb + c.axis * wc,
            a.normal * wa + b.normal * wb + c.normal * wc,
        );
        let distance = cell.entry + meeting.distance;
        let mut yarn = facet.yarn;
        yarn.lateral += cell.lateral(yarn.system);
        Some(Hit {
            position: origin + direction * distance,
            distance,
            frame,
            yarn,
        })
    }

    /// Whether any yarn but `skip` stands on the ray. The response f* of a yarn already holds the yarn's shadow on
    /// itself, so the owner of the shaded point is skipped whole, all along its length.
    pub fn occluded(&self, origin: &Vec3, direction: &Vec3, skip: YarnId) -> bool {
        let mut blocked = false;
        self.walk(origin, direction, |ray, cell, limit| {
            let mut skip = skip;
            skip.lateral -= cell.lateral(skip.system);
            let mut limit = limit;
            self.traverse(ray, Some(skip), &mut limit, |_, _, _| {
                blocked = true;
                ControlFlow::Break(())
            });
            if blocked {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        blocked
    }

    /// Visits, front to back, the cells that the ray crosses between the cloth's lowest and highest point, with the
    /// ray moved into the first cell and restarted where it enters that slab, and the distance at which it leaves the
    /// cell. Every facet that reaches into a cell is stored with it, so the first cell with a hit has the nearest one.
    fn walk(&self, origin: &Vec3, direction: &Vec3, mut visit: impl FnMut(&Ray, Cell, f64) -> ControlFlow<()>) {
        let inverse = direction.map(|x| finite_inverse(x, 1e-200));
        let [bottom, top] = self.slab_mm.map(|z| (z - origin.z) * inverse.z);
        let entry = bottom.min(top).max(0.0);
        let exit = bottom.max(top) - entry;
        if exit < 0.0 {
            return;
        }
        let start = origin + direction * entry;
        let mut index = [0, 1].map(|k| (start[k] / self.cell_mm[k]).floor());
        for _ in 0..MAX_CELLS {
            let leave = [0, 1].map(|k| {
                let wall = if direction[k] > 0.0 { index[k] + 1.0 } else { index[k] };
                // A ray along the other axis never reaches a wall, also when it runs in one.
                if direction[k] == 0.0 {
                    f64::INFINITY
                } else {
                    (wall * self.cell_mm[k] - start[k]) * inverse[k]
                }
            });
            let axis = usize::from(leave[1] < leave[0]);
            let shift = Vec3::new(index[0] * self.cell_mm[0], index[1] * self.cell_mm[1], 0.0);
            let ray = Ray {
                origin: start - shift,
                direction: *direction,
            };
            let cell = Cell {
                entry,
                index: index.map(|i| i as i64),
            };
            let seam = SEAM * self.cell_mm[axis] * inverse[axis].abs();
            let limit = exit.min(leave[axis] + if leave[axis].is_finite() { seam } else { 0.0 });
            if visit(&ray, cell, limit).is_break() || leave[axis] >= exit {
                return;
            }
            index[axis] += direction[axis].signum();
        }
    }

    /// Calls `meet` for facets on the ray nearer than `limit`, which it may lower, but for those of yarn `skip`.
    fn traverse<'a>(
        &'a self,
        ray: &Ray,
        skip: Option<YarnId>,
        limit: &mut f64,
        mut meet: impl FnMut(&'a Facet, Meeting, &mut f64) -> ControlFlow<()>,
    ) {
        let nodes = &self.orders[octant(&ray.direction)];
        let boxed = BoxRay {
            origin: ray.origin.map(|x| x as f32).into(),
            inverse: ray.direction.map(|x| finite_inverse(x, 1e-30) as f32).into(),
        };
        // One that is not in the cell is nowhere in the hierarchy.
        let skip = skip
            .and_then(|yarn| self.yarns.binary_search(&yarn).ok())
            .map_or(NO_YARN, |place| place as u32);
        let mut at = 0;
        while let Some(node) = nodes.get(at) {
            if node.yarn == skip || !boxed.meets(node, *limit as f32) {
                at = node.skip as usize;
                continue;
            }
            at += 1;
            if let Some(facet) = self.facets.get(node.facet as usize)
                && let Some(meeting) = ray.meets_facet(&facet.corners, *limit)
                && meet(facet, meeting, limit).is_break()
            {
                return;
            }
        }
    }
}

/// The facets of the endless cloth that reach into the cell [0, cell x] × [0, cell y]: those of the repeat and the
/// ends of their copies, for sections perpendicular to a climbing yarn stand out of the repeat.
fn facets_of_cell(mesh: &Mesh, cell_mm: [f64; 2]) -> Vec<Facet> {
    let mut facets = Vec::with_capacity(mesh.quads.len() + mesh.quads.len() / 4);
    for Quad { corners, system, index } in &mesh.quads {
        for (step_x, step_y) in [-1, 0, 1].into_iter().flat_map(|x| [-1, 0, 1].map(|y| (x, y))) {
            let shift = Vec3::new(f64::from(step_x) * cell_mm[0], f64::from(step_y) * cell_mm[1], 0.0);
            let corners_mm = corners.map(|v| mesh.vertices[v as usize].position + shift);
            let reaches = |k: usize| {
                let seam = SEAM * cell_mm[k];
                corners_mm.iter().any(|c| c[k] >= -seam) && corners_mm.iter().any(|c| c[k] <= cell_mm[k] + seam)
            };
            if reaches(0) && reaches(1) {
                let lateral = match system {
                    System::Warp => step_y,
                    System::Weft => step_x,
                };
                facets.push(Facet {
                    corners: corners_mm,
                    vertices: *corners,
                    yarn: YarnId {
                        system: *system,
                        index: *index,
                        lateral: i64::from(lateral),
                    },
                });
            }
        }
    }
    facets
}

struct BoxedFacet {
    bounds: Aabb<f64, 3>,
    node: usize,
}

impl Bounded<f64, 3> for BoxedFacet {
    fn aabb(&self) -> Aabb<f64, 3> {
        self.bounds
    }
}

impl BHShape<f64, 3> for BoxedFacet {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

fn hierarchy(facets: &[Facet], yarns: &[YarnId]) -> [Vec<Node>; 8] {
    let mut shapes: Vec<BoxedFacet> = facets
        .iter()
        .map(|facet| {
            let [a, b, c, d] = facet.corners;
            let low = a.inf(&b).inf(&c.inf(&d));
            let high = a.sup(&b).sup(&c.sup(&d));
            BoxedFacet {
                bounds: Aabb::with_bounds(Point3::from(low), Point3::from(high)),
                node: 0,
            }
        })
        .collect();
    let tree = Bvh::build(&mut shapes).nodes;
    let owners: Vec<u32> = facets
        .iter()
        .map(|facet| yarns.partition_point(|yarn| yarn < &facet.yarn) as u32)
        .collect();
    let everything = shapes.iter().fold(Aabb::empty(), |all, shape| all.join(&shape.bounds));
    let margin = BOX_MARGIN * everything.size().sum();
    std::array::from_fn(|octant| {
        let mut nodes = Vec::with_capacity(tree.len());
        let diagonal = Vec3::from_fn(|k, _| if octant >> k & 1 == 1 { -1.0 } else { 1.0 });
        flatten(&tree, 0, &everything, &diagonal, margin, &owners, &mut nodes);
        nodes
    })
}

/// Which signs a direction has: bit k is set where component k is negative, −0 included as in [`finite_inverse`].
fn octant(direction: &Vec3) -> usize {
    (0..3).map(|k| usize::from(direction[k].is_sign_negative()) << k).sum()
}

/// Writes the subtree in depth-first order, of two children the one first that a ray along `direction` meets first.
fn flatten(
    tree: &[BvhNode<f64, 3>],
    at: usize,
    bounds: &Aabb<f64, 3>,
    direction: &Vec3,
    margin: f64,
    owners: &[u32],
    nodes: &mut Vec<Node>,
) {
    let place = nodes.len();
    let low = [0, 1, 2].map(|k| (bounds.min[k] - margin) as f32);
    let high = [0, 1, 2].map(|k| (bounds.max[k] + margin) as f32);
    let pick = |k: usize, first: bool| if (direction[k] > 0.0) == first { low[k] } else { high[k] };
    nodes.push(Node {
        near: [0, 1, 2].map(|k| pick(k, true)),
        far: [0, 1, 2].map(|k| pick(k, false)),
        skip: 0,
        facet: u32::MAX,
        yarn: SEVERAL_YARNS,
    });
    match &tree[at] {
        BvhNode::Leaf { shape_index, .. } => {
            nodes[place].facet = *shape_index as u32;
            nodes[place].yarn = owners[*shape_index];
        }
        BvhNode::Node {
            child_l_index,
            child_l_aabb,
            child_r_index,
            child_r_aabb,
            ..
        } => {
            let mut children = [(*child_l_index, child_l_aabb), (*child_r_index, child_r_aabb)];
            if (child_r_aabb.center() - child_l_aabb.center()).dot(direction) < 0.0 {
                children.reverse();
            }
            let below = children.map(|(child, child_bounds)| {
                let start = nodes.len();
                flatten(tree, child, child_bounds, direction, margin, owners, nodes);
                nodes[start].yarn
            });
            if below[0] == below[1] {
                nodes[place].yarn = below[0];
            }
        }
    }
    nodes[place].skip = nodes.len() as u32;
}

/// Place of a visited cell in the endless cloth.
#[derive(Clone, Copy)]
struct Cell {
    /// Distance along the ray from its origin to the slab, where the moved ray starts.
    entry: f64,
    index: [i64; 2],
}

impl Cell {
    fn lateral(&self, system: System) -> i64 {
        match system {
            System::Warp => self.index[1],
            System::Weft => self.index[0],
        }
    }
}

/// Point of a ray on one triangle of a facet: the triangle's corners and the weights of the last two.
#[derive(Clone, Copy)]
struct Meeting {
    distance: f64,
    corners: [usize; 3],
    weights: [f64; 2],
}

struct Ray {
    origin: Vec3,
    direction: Vec3,
}

/// A ray as the box test wants it.
struct BoxRay {
    origin: [f32; 3],
    inverse: [f32; 3],
}

/// 1/x, kept finite below the smallest x told apart from 0: slab tests then never meet 0 · ∞.
fn finite_inverse(x: f64, smallest: f64) -> f64 {
    1.0 / x.abs().max(smallest).copysign(x)
}

impl BoxRay {
    fn meets(&self, node: &Node, limit: f32) -> bool {
        let (mut near, mut far) = (0.0, limit);
        for k in 0..3 {
            let first = (node.near[k] - self.origin[k]) * self.inverse[k];
            let last = (node.far[k] - self.origin[k]) * self.inverse[k];
            near = if first > near { first } else { near };
            far = if last < far { last } else { far };
        }
        near <= far
    }
}

impl Ray {
    /// Nearest meeting with the facet's two triangles, (a, b, c) and (a, d, c), from either side, in [0, limit].
    /// T. Möller, B. Trumbore, "Fast, minimum storage ray/triangle intersection", J. Graphics Tools 2 (1997) 21; what
    /// belongs to the diagonal a–c serves both triangles.
    fn meets_facet(&self, corners: &[Vec3; 4], mut limit: f64) -> Option<Meeting> {
        let a = corners[0];
        let ac = corners[2] - a;
        let from_a = self.origin - a;
        let p = self.direction.cross(&ac);
        let beside = from_a.dot(&p);
        let mut found = None;
        for third in [1, 3] {
            let edge = corners[third] - a;
            let inverse = 1.0 / edge.dot(&p);
            let third_weight = beside * inverse;
            // An edge-on triangle has a zero determinant: its weights are infinite or NaN and fail here.
            if !(0.0..=1.0).contains(&third_weight) {
                continue;
            }
            let q = from_a.cross(&edge);
            let c_weight = self.direction.dot(&q) * inverse;
            let distance = ac.dot(&q) * inverse;
            if c_weight >= 0.0 && third_weight + c_weight <= 1.0 && distance >= 0.0 && distance <= limit {
                limit = distance;
                found = Some(Meeting {
                    distance,
                    corners: [0, third, 2],
                    weights: [third_weight, c_weight],
                });
            }
        }
        found
    }
}
