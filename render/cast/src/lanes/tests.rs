//! Every instruction set that this processor has against arithmetic lane by lane.

use super::{Isa, Kernel, LANES, Lanes, Portable, Texels};
use sandtable_terrain::{Slab, SlabView, Slot};
use std::any::type_name;
use std::array::from_fn;
use std::sync::Arc;

/// A test of each instruction set: `l` are its lanes.
macro_rules! each_isa {
    ($(fn $name:ident<$lanes:ident>($l:ident) $body:block)*) => {$(
        #[test]
        fn $name() {
            struct Check;
            impl Kernel for Check {
                type Output = ();
                fn run<$lanes: Lanes>(self, $l: $lanes) $body
            }
            for isa in Isa::all_ways() {
                isa.run(Check);
            }
        }
    )*};
}

mod arithmetic;
mod memory;
mod texels;
mod tiles;

/// Numbers that look random, the same ones each time.
struct Random(u64);

impl Random {
    fn new() -> Self {
        Self(2463534242)
    }

    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 24) as u32
    }

    fn below(&mut self, limit: u32) -> u32 {
        self.next() % limit
    }

    /// In [0, 1], both ends included.
    fn share(&mut self) -> f32 {
        self.below(10_001) as f32 / 10_000.0
    }

    /// Any bits at all, or one of `special`.
    fn bits(&mut self, special: &[u32]) -> u32 {
        match self.below(3) {
            0 => special[self.below(special.len() as u32) as usize],
            _ => self.next(),
        }
    }

    fn float(&mut self) -> f32 {
        const SPECIAL: [f32; 24] = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            0.5,
            -1.5,
            3.0,
            1e-30,
            -1e30,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
            -f32::NAN,
            f32::MIN_POSITIVE,
            -f32::MIN_POSITIVE,
            f32::MIN_POSITIVE / 2.0,
            -f32::MIN_POSITIVE / 4.0,
            1.401e-45,
            f32::MAX,
            f32::MIN,
            8_388_607.5,
            -2_147_483_600.0,
            2_147_483_500.0,
            0.333_333_34,
        ];
        f32::from_bits(self.bits(&SPECIAL.map(f32::to_bits)))
    }

    fn int(&mut self) -> i32 {
        const SPECIAL: [i32; 8] = [0, 1, -1, 2, i32::MAX, i32::MIN, 1 << 24 | 1, 0xffff];
        self.bits(&SPECIAL.map(|special| special as u32)) as i32
    }

    fn lanes<T>(&mut self, mut lane: impl FnMut(&mut Self) -> T) -> [T; LANES] {
        from_fn(|_| lane(self))
    }
}

/// Groups that each test tries: enough for each pair of special values.
const GROUPS: usize = 2000;

fn floats<L: Lanes>(l: L, value: L::F) -> [f32; LANES] {
    let mut lanes = [0.0; LANES];
    l.store(value, &mut lanes);
    lanes
}

fn ints<L: Lanes>(l: L, value: L::I) -> [i32; LANES] {
    let mut lanes = [0; LANES];
    l.store_i(value, &mut lanes);
    lanes
}

fn truths(mask: u16) -> [bool; LANES] {
    from_fn(|k| mask >> k & 1 == 1)
}

/// The same bits in all lanes.
fn assert_same<L: Lanes>(l: L, what: &str, found: L::F, expected: [f32; LANES]) {
    let (found, expected) = (floats(l, found), expected);
    assert_eq!(
        found.map(f32::to_bits),
        expected.map(f32::to_bits),
        "{what} on {}: {found:?}, not {expected:?}",
        type_name::<L>()
    );
}

/// The same bits in all lanes; of NaNs only that they are: which of its operands' or whose sign a
/// new one gets depends on the processor.
fn assert_same_number<L: Lanes>(l: L, what: &str, found: L::F, expected: [f32; LANES]) {
    let one_nan = |lane: f32| if lane.is_nan() { f32::NAN } else { lane };
    let (found, expected) = (floats(l, found).map(one_nan), expected.map(one_nan));
    assert_eq!(
        found.map(f32::to_bits),
        expected.map(f32::to_bits),
        "{what} on {}: {found:?}, not {expected:?}",
        type_name::<L>()
    );
}

fn assert_same_ints<L: Lanes>(l: L, what: &str, found: L::I, expected: [i32; LANES]) {
    assert_eq!(ints(l, found), expected, "{what} on {}", type_name::<L>());
}

fn assert_same_mask<L: Lanes>(l: L, what: &str, found: L::M, expected: [bool; LANES]) {
    assert_eq!(
        truths(l.bits(found)),
        expected,
        "{what} on {}",
        type_name::<L>()
    );
}

#[test]
fn the_best_is_the_first_and_the_reference_the_last() {
    let names: Vec<_> = Isa::all().into_iter().map(Isa::name).collect();
    assert_eq!(names[0], Isa::best().name());
    assert_eq!(names.last(), Some(&"portable"));
    let order = ["avx512", "avx2", "neon", "portable"];
    let ranks: Vec<_> = names
        .iter()
        .map(|name| order.iter().position(|other| other == name))
        .collect();
    assert!(ranks.is_sorted() && !ranks.contains(&None), "{names:?}");
}
