//! The instruction sets that kernels are compiled for, and the choice among them.

use super::{Lanes, Portable};
use std::fmt;

/// An instruction set that this processor has.
#[derive(Clone, Copy)]
pub(crate) enum Isa {
    #[cfg(target_arch = "x86_64")]
    Avx512(super::avx512::Avx512),
    #[cfg(target_arch = "x86_64")]
    Avx2(super::avx2::Avx2),
    #[cfg(target_arch = "aarch64")]
    Neon(super::neon::Neon),
    Portable(Portable),
}

/// Work that is compiled for each instruction set.
pub(crate) trait Kernel {
    type Output;
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

impl Isa {
    /// All that this processor has, the fastest first.
    pub(crate) fn all() -> Vec<Self> {
        let mut all = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            all.extend(super::avx512::Avx512::detect().map(Self::Avx512));
            all.extend(super::avx2::Avx2::detect().map(Self::Avx2));
        }
        #[cfg(target_arch = "aarch64")]
        all.push(Self::Neon(super::neon::Neon::new()));
        all.push(Self::Portable(Portable));
        all
    }

    /// All that this processor has, in all ways of using them.
    #[cfg(test)]
    pub(crate) fn all_ways() -> Vec<Self> {
        let ways = |isa| match isa {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(lanes) => vec![isa, Self::Avx512(lanes.reading_otherwise())],
            _ => vec![isa],
        };
        Self::all().into_iter().flat_map(ways).collect()
    }

    /// The fastest that this processor has.
    pub(crate) fn best() -> Self {
        Self::all()[0]
    }

    /// The name by which users ask for it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => "avx512",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => "avx2",
            #[cfg(target_arch = "aarch64")]
            Self::Neon(_) => "neon",
            Self::Portable(_) => "portable",
        }
    }

    /// Runs `kernel` with it.
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(lanes) => lanes.vectorize(
                #[inline(always)]
                || kernel.run(lanes),
            ),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(lanes) => lanes.vectorize(
                #[inline(always)]
                || kernel.run(lanes),
            ),
            #[cfg(target_arch = "aarch64")]
            Self::Neon(lanes) => kernel.run(lanes),
            Self::Portable(lanes) => kernel.run(lanes),
        }
    }
}

impl fmt::Debug for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
