//! The recursion itself, for one state or several side by side.
//!
//! Each link is seen from the frame of its own joint: Z along the axis, moving with the link. A way
//! `Tx(a) Tz(d) Rx(alpha)` that does not move is behind each joint, as in the table. `U` below is
//! the matrix that gives the acceleration of a link's point `r` against its origin:
//! `U r = dw x r + w x (w x r)`.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use crate::dynamics::body::Body;
use crate::lanes::{Number, difference, sum};
use crate::serial::JointKind;

/// Three numbers along x, y and z.
type Vector<N> = [N; 3];

/// Sine and cosine.
pub(crate) type Turn<N> = (N, N);

/// `Rx(alpha)`: right angles take no multiplication.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Twist {
    None,
    Quarter,
    QuarterBack,
    Half,
    Any { sine: f64, cosine: f64 },
}

impl Twist {
    pub(crate) fn of(alpha: f64) -> Self {
        const EXACT: f64 = 1e-15;
        let (sine, cosine) = alpha.sin_cos();
        if cosine.abs() < EXACT {
            if sine > 0.0 {
                Twist::Quarter
            } else {
                Twist::QuarterBack
            }
        } else if sine.abs() < EXACT {
            if cosine > 0.0 {
                Twist::None
            } else {
                Twist::Half
            }
        } else {
            Twist::Any { sine, cosine }
        }
    }

    /// The opposite turn.
    fn back(self) -> Self {
        match self {
            Twist::None | Twist::Half => self,
            Twist::Quarter => Twist::QuarterBack,
            Twist::QuarterBack => Twist::Quarter,
            Twist::Any { sine, cosine } => Twist::Any {
                sine: -sine,
                cosine,
            },
        }
    }

    /// `Rx(alpha)` of each vector.
    #[inline(always)]
    fn turn<N: Number, const M: usize>(self, vectors: &mut [Vector<N>; M]) {
        match self {
            Twist::None => {}
            Twist::Quarter => {
                for vector in vectors {
                    let [x, y, z] = *vector;
                    *vector = [x, -z, y];
                }
            }
            Twist::QuarterBack => {
                for vector in vectors {
                    let [x, y, z] = *vector;
                    *vector = [x, z, -y];
                }
            }
            Twist::Half => {
                for vector in vectors {
                    let [x, y, z] = *vector;
                    *vector = [x, -y, -z];
                }
            }
            Twist::Any { sine, cosine } => {
                for vector in vectors {
                    let [x, y, z] = *vector;
                    *vector = [
                        x,
                        (-z).scaled_plus(sine, y * cosine),
                        z.scaled_plus(cosine, y * sine),
                    ];
                }
            }
        }
    }
}

/// A joint with its link.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub(crate) kind: JointKind,
    /// The way from the frame before: along its X and its Z, where there is one, in meters.
    pub(crate) a: Option<f64>,
    pub(crate) d: Option<f64>,
    /// The twist after it, and back.
    pub(crate) twist: Twist,
    pub(crate) untwist: Twist,
    pub(crate) moments: Moments,
}

impl Link {
    pub(crate) fn new(kind: JointKind, [a, d, alpha]: [f64; 3], body: &Body) -> Self {
        let way = |length: f64| (length.abs() > 0.0).then_some(length);
        let twist = Twist::of(alpha);
        Self {
            kind,
            a: way(a),
            d: way(d),
            twist,
            untwist: twist.back(),
            moments: Moments::of(body),
        }
    }
}

/// The moments of a link's mass, see [`Body`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    x: f64,
    y: f64,
    xx: f64,
    yy: f64,
    xy: f64,
    xz: f64,
    yz: f64,
    /// Mass, and its moments along Z: a link that turns about Z has left them to the one before.
    on_axis: Option<[f64; 3]>,
}

impl Moments {
    fn of(
        Body {
            mass,
            first,
            second,
        }: &Body,
    ) -> Self {
        let on_axis = [*mass, first.z, second.m33];
        Self {
            x: first.x,
            y: first.y,
            xx: second.m11,
            yy: second.m22,
            xy: second.m12,
            xz: second.m13,
            yz: second.m23,
            on_axis: on_axis
                .iter()
                .any(|part| part.abs() > 0.0)
                .then_some(on_axis),
        }
    }

    /// What has to act on the link: the integrals of `acc + U r` and of its moment about the origin.
    #[inline(always)]
    fn forces<N: Number>(&self, [ax, ay, az]: Vector<N>, u: &[Vector<N>; 3]) -> [Vector<N>; 2] {
        let [[uxx, uxy, uxz], [uyx, uyy, uyz], [uzx, uzy, uzz]] = *u;
        let m = self;
        let mut force = [
            uxx.scaled_plus(m.x, uxy * m.y),
            uyx.scaled_plus(m.x, uyy * m.y),
            uzx.scaled_plus(m.x, uzy * m.y),
        ];
        // A vector's sign goes into the multiplication, a factor's does not.
        let x = (-uyx).scaled_plus(m.xz, az * m.y);
        let x = (uzz - uyy).scaled_plus(m.yz, x);
        let x = uzx.scaled_plus(m.xy, uzy.scaled_plus(m.yy, x));
        let y = (-az).scaled_plus(m.x, uxy * m.yz);
        let y = (uxx - uzz).scaled_plus(m.xz, y);
        let y = (-uzx).scaled_plus(m.xx, (-uzy).scaled_plus(m.xy, y));
        let z = (-ax).scaled_plus(m.y, ay * m.x);
        let z = (uyy - uxx).scaled_plus(m.xy, z);
        let z = uyx.scaled_plus(m.xx, uyz.scaled_plus(m.xz, z));
        let z = (-uxy).scaled_plus(m.yy, (-uxz).scaled_plus(m.yz, z));
        let mut moment = [x, y, z];
        if let Some([mass, along, second]) = self.on_axis {
            force = [
                ax.scaled_plus(mass, uxz.scaled_plus(along, force[0])),
                ay.scaled_plus(mass, uyz.scaled_plus(along, force[1])),
                az.scaled_plus(mass, uzz.scaled_plus(along, force[2])),
            ];
            moment = [
                (-ay).scaled_plus(along, (-uyz).scaled_plus(second, moment[0])),
                ax.scaled_plus(along, uxz.scaled_plus(second, moment[1])),
                moment[2],
            ];
        }
        [force, moment]
    }
}

/// What goes into [`forces`] and comes out, of K joints at most. It is made once for many states.
pub(crate) struct Room<N, const K: usize> {
    /// Each joint's value, rate and acceleration, in radians and meters.
    pub(crate) motions: [[N; 3]; K],
    /// About each joint's axis.
    pub(crate) turns: [Turn<N>; K],
    /// The forces of the table's variables, base first: torques in N m, forces in N.
    pub(crate) forces: [N; K],
    /// Force and moment on each link.
    acting: [[Vector<N>; 2]; K],
    zero: N,
}

impl<N: Number, const K: usize> Room<N, K> {
    #[inline(always)]
    pub(crate) fn new(zero: N) -> Self {
        Self {
            motions: [[zero; 3]; K],
            turns: [(zero, zero); K],
            forces: [zero; K],
            acting: [[[zero; 3]; 2]; K],
            zero,
        }
    }
}

/// The forces for the motions and turns in `room`. The base is accelerated upwards by what gravity
/// is downwards, `lift` in its own frame.
#[inline(always)]
pub(crate) fn forces<N: Number, const K: usize>(
    links: &[Link],
    lift: [f64; 3],
    room: &mut Room<N, K>,
) {
    let Room {
        motions,
        turns,
        acting,
        forces,
        zero,
    } = room;
    let zero = *zero;
    let [x, y, z] = lift;
    let mut moving = Moving {
        w: [zero; 3],
        dw: [zero; 3],
        acc: [zero.like(x), zero.like(y), zero.like(z)],
        u: [[zero; 3]; 3],
    };
    let joints = links.iter().zip(&*turns).zip(&*motions);
    for (((link, turn), motion), acting) in joints.zip(&mut *acting) {
        moving.goes_on(link, *turn, *motion);
        *acting = link.moments.forces(moving.acc, &moving.u);
    }

    let [mut f, mut n] = [[zero; 3]; 2];
    let joints = links.iter().zip(&*turns).zip(&*motions);
    let all = joints.zip(&*acting).zip(forces);
    for ((((link, (s, c)), [q, ..]), [force, moment]), out) in all.rev() {
        f = plus(f, *force);
        n = plus(n, *moment);
        match link.kind {
            JointKind::Revolute => *out = n[2],
            JointKind::Prismatic => {
                *out = f[2];
                n[0] = (-f[1]).times_plus(*q, n[0]);
                n[1] = f[0].times_plus(*q, n[1]);
            }
        }
        let mut both = [f, n];
        for [x, y, _] in &mut both {
            (*x, *y) = (difference((*c, *x), (*s, *y)), sum((*s, *x), (*c, *y)));
        }
        link.twist.turn(&mut both);
        [f, n] = both;
        if let Some(a) = link.a {
            n[1] = (-f[2]).scaled_plus(a, n[1]);
            n[2] = f[1].scaled_plus(a, n[2]);
        }
        if let Some(d) = link.d {
            n[0] = (-f[1]).scaled_plus(d, n[0]);
            n[1] = f[0].scaled_plus(d, n[1]);
        }
    }
}

/// How a link moves: angular velocity and acceleration, the acceleration of its origin, and `U`.
struct Moving<N> {
    w: Vector<N>,
    dw: Vector<N>,
    acc: Vector<N>,
    u: [Vector<N>; 3],
}

impl<N: Number> Moving<N> {
    /// On to the link behind.
    #[inline(always)]
    fn goes_on(&mut self, link: &Link, (s, c): Turn<N>, [q, rate, acceleration]: [N; 3]) {
        let Self { w, dw, acc, u } = self;
        if let Some(a) = link.a {
            for (acc, [x, _, _]) in acc.iter_mut().zip(&*u) {
                *acc = x.scaled_plus(a, *acc);
            }
        }
        if let Some(d) = link.d {
            for (acc, [_, _, z]) in acc.iter_mut().zip(&*u) {
                *acc = z.scaled_plus(d, *acc);
            }
        }
        let mut three = [*w, *dw, *acc];
        link.untwist.turn(&mut three);
        if link.kind == JointKind::Prismatic {
            let [[wx, wy, wz], [dwx, dwy, _], [x, y, z]] = three;
            let twice = rate + rate;
            // The third column of U, times how far the joint is out; and Coriolis' part.
            three[2] = [
                wx.times_plus(wz, dwy)
                    .times_plus(q, wy.times_plus(twice, x)),
                wy.times_plus(wz, -dwx)
                    .times_plus(q, (-wx).times_plus(twice, y)),
                (-sum((wx, wx), (wy, wy))).times_plus(q, z + acceleration),
            ];
        }
        for [x, y, _] in &mut three {
            (*x, *y) = (sum((c, *x), (s, *y)), difference((c, *y), (s, *x)));
        }
        [*w, *dw, *acc] = three;
        if link.kind == JointKind::Revolute {
            let [wx, wy, _] = *w;
            dw[0] = wy.times_plus(rate, dw[0]);
            dw[1] = (-wx).times_plus(rate, dw[1]);
            dw[2] = dw[2] + acceleration;
            w[2] = w[2] + rate;
        }
        let ([wx, wy, wz], [dwx, dwy, dwz]) = (*w, *dw);
        let (xx, yy, zz) = (wx * wx, wy * wy, wz * wz);
        let (xy, xz, yz) = (wx * wy, wx * wz, wy * wz);
        *u = [
            [-(yy + zz), xy - dwz, xz + dwy],
            [xy + dwz, -(xx + zz), yz - dwx],
            [xz - dwy, yz + dwx, -(xx + yy)],
        ];
    }
}

#[inline(always)]
fn plus<N: Number>([ax, ay, az]: Vector<N>, [bx, by, bz]: Vector<N>) -> Vector<N> {
    [ax + bx, ay + by, az + bz]
}
