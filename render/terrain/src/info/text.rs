//! A file's description for people.

use super::{FileInfo, SampleValue};
use std::fmt;

impl fmt::Display for FileInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let types: Vec<_> = self
            .dtype
            .first()
            .map(|sample| format!("{sample:?}"))
            .into_iter()
            .collect();
        writeln!(
            f,
            "format       {}, {} by {} cells, {} of {}",
            self.driver,
            self.width,
            self.height,
            plural(self.bands, "band"),
            types.join("")
        )?;
        writeln!(
            f,
            "stored       in blocks of {} by {}, {}, {}",
            self.block[0],
            self.block[1],
            self.compression.as_deref().unwrap_or("uncompressed"),
            plural(self.overviews, "overview")
        )?;
        writeln!(
            f,
            "CRS          {}",
            self.crs.as_deref().unwrap_or("not named")
        )?;
        if let Some(vertical) = &self.vertical_crs {
            writeln!(f, "vertical CRS {vertical}")?;
        }
        if let Some([x, dx, _, y, _, dy]) = self.geotransform {
            writeln!(f, "origin       {x}, {y}")?;
            writeln!(f, "cell         {dx} by {}", -dy)?;
        }
        if let Some(extent) = self.extent_outer_pixel_edges {
            writeln!(
                f,
                "extent       west {}, south {}, east {}, north {} (outer edges)",
                extent.minx, extent.miny, extent.maxx, extent.maxy
            )?;
        }
        if let Some(pixel_is) = self.area_or_point {
            writeln!(f, "cells are    {}", format!("{pixel_is:?}").to_lowercase())?;
        }
        for (index, band) in self.band_info.iter().enumerate() {
            write!(f, "band {:<8}{:?}", index + 1, band.color)?;
            if let Some(unit) = &band.unit {
                write!(f, " in {unit}")?;
            }
            if let (Some(min), Some(max), Some(mean)) = (band.min, band.max, band.mean) {
                write!(f, ", {min} to {max}, mean {mean:.3}")?;
            }
            write!(
                f,
                ", {} valid, {} without a value",
                band.valid, band.invalid
            )?;
            if let Some(nodata) = band.nodata {
                write!(f, " (nodata {nodata})")?;
            }
            let (scale, offset) = (band.scale.unwrap_or(1.0), band.offset.unwrap_or(0.0));
            if (scale, offset) != (1.0, 0.0) {
                write!(
                    f,
                    "; as stored, to be multiplied by {scale}, then {offset} added"
                )?;
            }
            writeln!(f)?;
        }
        for sample in &self.samples {
            write!(f, "cell {},{}", sample.col, sample.row)?;
            if let (Some(x), Some(y)) = (sample.x, sample.y) {
                write!(f, " at {x}, {y}")?;
            }
            let nodata = if sample.nodata { " (nodata)" } else { "" };
            writeln!(f, ": {}{nodata}", sample.value)?;
        }
        for note in &self.notes {
            writeln!(f, "note         {note}")?;
        }
        Ok(())
    }
}

fn plural(count: usize, what: &str) -> String {
    match count {
        1 => format!("1 {what}"),
        count => format!("{count} {what}s"),
    }
}

impl fmt::Display for SampleValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(value) => value.fmt(f),
            Self::Real(value) => value.fmt(f),
            Self::Bands(values) => {
                let texts: Vec<_> = values.iter().map(ToString::to_string).collect();
                f.write_str(&texts.join(" "))
            }
        }
    }
}
