//! A frame as arrays, and back.

use super::{Frame, FrameBodies, FrameMembranes, FramePairs, FrameWalls, NONE, STATES};
use crate::tables::{Array, Column, TableError, Tables};

/// Columns of a struct as arrays of these names, and back. The columns after `[KEY + MORE]` have MORE
/// rows more than the array `KEY`.
macro_rules! columns {
    ($type:ident, $prefix:literal, $([$key:literal + $more:literal] $($field:ident)*),*) => {
        impl $type {
            fn put(&self, tables: &mut Tables) {
                $($(tables.put(concat!($prefix, ".", stringify!($field)), self.$field.array());)*)*
            }

            fn read(tables: &Tables) -> Result<Self, TableError> {
                Ok(Self {$($($field: {
                    let rows = tables.rows(concat!($prefix, ".", $key))? + $more;
                    Column::read(tables, concat!($prefix, ".", stringify!($field)), rows)?
                },)*)*})
            }
        }
    };
}

columns!(FrameBodies, "bodies", ["id" + 0] id offset_m radius_m displacement_m rotation_rad
    velocity_m_s angular_velocity_rad_s material group stress_pa fragment);
columns!(FramePairs, "pairs", ["a" + 0] a b bond state p_n q_n tau_nm gap_m angle_rad);
columns!(FrameWalls, "walls", ["id" + 0] id name is_thin force, ["id" + 1] first_point,
    ["point_m" + 0] point_m);
columns!(FrameMembranes, "membranes", ["name" + 0] name is_closed, ["name" + 1] first_point,
    ["point_m" + 0] body point_m);

/// First word of the array `format`.
const FORMAT: &str = "clastic frame";
/// Version of the format, which follows the word.
const VERSION: &str = "1";

impl Frame {
    /// The frame as arrays.
    pub fn tables(&self) -> Tables {
        let mut tables = Tables::default();
        let mut put = |name: &str, array: Array| tables.put(name, array);
        put("format", Array::single(format!("{FORMAT} {VERSION}")));
        put("increment", Array::single(self.increment));
        put("stage", Array::single(self.stage.clone()));
        put("time_s", Array::single(self.time_s));
        put("thickness_m", Array::single(self.thickness_m));
        put("axial_strain", Array::single(self.axial_strain.unwrap_or(f64::NAN)));
        put("axial_stress_pa", Array::single(self.axial_stress_pa.unwrap_or(f64::NAN)));
        put("origin_m", Array::column(self.origin_m));
        put("cell_m", Array::column(self.cell_m.unwrap_or_default()));
        put("materials.name", Array::column(self.materials.iter().cloned()));
        put("groups.name", Array::column(self.groups.iter().cloned()));
        self.bodies.put(&mut tables);
        self.pairs.put(&mut tables);
        self.walls.put(&mut tables);
        self.membranes.put(&mut tables);
        tables
    }

    /// The frame of arrays.
    pub(crate) fn from_tables(tables: &Tables) -> Result<Self, TableError> {
        let format: String = tables.single("format").unwrap_or_default();
        let Some(version) = format.strip_prefix(FORMAT).map(str::trim) else {
            let what = "not a frame; give a `.npz` file of the folder `frames` of a run";
            return Err(TableError::Foreign(what.to_owned()));
        };
        if version != VERSION {
            return Err(TableError::Foreign(format!(
                "a frame of format {version}, which this clastic does not read; run the scene again"
            )));
        }
        let known = |name: &str| Ok(Some(tables.single(name)?).filter(|x: &f64| !x.is_nan()));
        let column = |name: &str| Column::read(tables, name, tables.rows(name)?);
        let origin = tables.values::<f64>("origin_m", &[2])?;
        let cell = tables.values::<f64>("cell_m", &[3])?;
        let frame = Self {
            increment: tables.single("increment")?,
            stage: tables.single("stage")?,
            time_s: tables.single("time_s")?,
            thickness_m: tables.single("thickness_m")?,
            axial_strain: known("axial_strain")?,
            axial_stress_pa: known("axial_stress_pa")?,
            origin_m: [origin[0], origin[1]],
            cell_m: Some([cell[0], cell[1], cell[2]]).filter(|cell| cell[0] > 0.0),
            materials: column("materials.name")?,
            groups: column("groups.name")?,
            bodies: FrameBodies::read(tables)?,
            pairs: FramePairs::read(tables)?,
            walls: FrameWalls::read(tables)?,
            membranes: FrameMembranes::read(tables)?,
        };
        frame.check()?;
        Ok(frame)
    }

    /// Checks that identities ascend, and that indices are in range.
    fn check(&self) -> Result<(), TableError> {
        let bodies = &self.bodies;
        if let Some(row) = bodies.id.windows(2).position(|pair| pair[0] >= pair[1]) {
            return Err(TableError::at("bodies.id", format!("does not ascend in row {}", row + 1)));
        }
        let (materials, groups) = (self.materials.len(), self.groups.len());
        let is_group = |g: &u32| *g == NONE || (*g as usize) < groups;
        let is_particle = |id: &u32| self.row(*id).is_some();
        let is_body = |id: &u32| is_particle(id) || self.walls.id.contains(id);
        let (pairs, membranes) = (&self.pairs, &self.membranes);
        in_range("bodies.material", &bodies.material, |m| (*m as usize) < materials)?;
        in_range("bodies.group", &bodies.group, is_group)?;
        in_range("bodies.fragment", &bodies.fragment, is_particle)?;
        in_range("pairs.state", &pairs.state, |state| usize::from(*state) < STATES.len())?;
        in_range("pairs.a", &pairs.a, is_particle)?;
        in_range("pairs.b", &pairs.b, is_body)?;
        in_range("membranes.body", &membranes.body, is_body)?;
        from_all("walls.first_point", &self.walls.first_point, self.walls.point_m.len())?;
        from_all("membranes.first_point", &membranes.first_point, membranes.point_m.len())
    }
}

/// Whether all values of a column are as they should be.
fn in_range<T>(name: &str, of: &[T], is_right: impl Fn(&T) -> bool) -> Result<(), TableError> {
    let wrong = |row| TableError::at(name, format!("the value in row {row} is out of range"));
    of.iter().position(|value| !is_right(value)).map_or(Ok(()), |row| Err(wrong(row)))
}

/// Whether places of first points go from 0 to the number of all points.
fn from_all(name: &str, first: &[u32], points: usize) -> Result<(), TableError> {
    let ends =
        first.first() == Some(&0) && first.last().is_some_and(|last| *last as usize == points);
    if !ends || first.windows(2).any(|pair| pair[0] > pair[1]) {
        return Err(TableError::at(name, "does not go from 0 to all points"));
    }
    Ok(())
}
