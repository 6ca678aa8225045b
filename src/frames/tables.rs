//! A frame as arrays, and back.

use super::files::FrameError;
use super::{Frame, FrameBodies, FrameMembranes, FramePairs, FrameWalls, NONE, STATES};
use crate::tables::{Array, TableError, Tables};

/// First word of the array `format`.
const FORMAT: &str = "clastic frame";
/// Version of the format, which follows the word.
const VERSION: &str = "1";

impl Frame {
    /// The frame as arrays.
    #[must_use]
    pub fn tables(&self) -> Tables {
        let mut tables = Tables::default();
        let mut put = |name: &str, array: Array| tables.put(name, array);
        put("format", Array::word(&format!("{FORMAT} {VERSION}")));
        put("increment", Array::count(self.increment));
        put("stage", Array::word(&self.stage));
        put("time_s", Array::value(self.time_s));
        put("thickness_m", Array::value(self.thickness_m));
        put("axial_strain", Array::value(self.axial_strain.unwrap_or(f64::NAN)));
        put("axial_stress_pa", Array::value(self.axial_stress_pa.unwrap_or(f64::NAN)));
        put("origin_m", Array::f64(self.origin_m.to_vec()));
        put("cell_m", Array::f64(self.cell_m.unwrap_or_default().to_vec()));
        put("materials.name", Array::text(self.materials.iter().cloned()));
        put("groups.name", Array::text(self.groups.iter().cloned()));
        let bodies = &self.bodies;
        put("bodies.id", Array::u32(bodies.id.clone()));
        put("bodies.offset_m", Array::f32_rows(&bodies.offset_m));
        put("bodies.radius_m", Array::f32(bodies.radius_m.clone()));
        put("bodies.displacement_m", Array::f32_rows(&bodies.displacement_m));
        put("bodies.rotation_rad", Array::f32(bodies.rotation_rad.clone()));
        put("bodies.velocity_m_s", Array::f32_rows(&bodies.velocity_m_s));
        put("bodies.angular_velocity_rad_s", Array::f32(bodies.angular_velocity_rad_s.clone()));
        put("bodies.material", Array::u32(bodies.material.clone()));
        put("bodies.group", Array::u32(bodies.group.clone()));
        put("bodies.stress_pa", Array::f32_rows(&bodies.stress_pa));
        put("bodies.fragment", Array::u32(bodies.fragment.clone()));
        let pairs = &self.pairs;
        put("pairs.a", Array::u32(pairs.a.clone()));
        put("pairs.b", Array::u32(pairs.b.clone()));
        put("pairs.bond", Array::u32(pairs.bond.clone()));
        put("pairs.state", Array::u8(pairs.state.clone()));
        put("pairs.p_n", Array::f32(pairs.p_n.clone()));
        put("pairs.q_n", Array::f32(pairs.q_n.clone()));
        put("pairs.tau_nm", Array::f32(pairs.tau_nm.clone()));
        put("pairs.gap_m", Array::f32(pairs.gap_m.clone()));
        put("pairs.angle_rad", Array::f32(pairs.angle_rad.clone()));
        let walls = &self.walls;
        put("walls.id", Array::u32(walls.id.clone()));
        put("walls.name", Array::text(walls.name.iter().cloned()));
        put("walls.is_thin", Array::bool(walls.is_thin.clone()));
        put("walls.force", Array::vectors(walls.force.iter().copied()));
        put("walls.first_point", Array::u32(walls.first_point.clone()));
        put("walls.point_m", Array::vectors(walls.point_m.iter().copied()));
        let membranes = &self.membranes;
        put("membranes.name", Array::text(membranes.name.iter().cloned()));
        put("membranes.is_closed", Array::bool(membranes.is_closed.clone()));
        put("membranes.first_point", Array::u32(membranes.first_point.clone()));
        put("membranes.body", Array::u32(membranes.body.clone()));
        put("membranes.point_m", Array::vectors(membranes.point_m.iter().copied()));
        tables
    }

    /// The frame of arrays.
    ///
    /// # Errors
    /// If they are no frame, or of another version, or contradict each other.
    pub fn from_tables(tables: &Tables) -> Result<Self, FrameError> {
        let format = tables.text("format", &[]).map_or("", |format| format[0].as_str());
        match format.strip_prefix(FORMAT).map(str::trim) {
            None => return Err(FrameError::Foreign),
            Some(version) if version != VERSION => {
                return Err(FrameError::Version(version.to_owned()));
            }
            Some(_) => {}
        }
        let number = |name: &str| Ok::<_, TableError>(tables.f64(name, &[])?[0]);
        let known = |name: &str| Ok::<_, TableError>(Some(number(name)?).filter(|x| !x.is_nan()));
        let column =
            |name: &str| Ok::<_, TableError>(tables.text(name, &[tables.rows(name)?])?.to_vec());
        let origin = tables.f64("origin_m", &[2])?;
        let cell = tables.f64("cell_m", &[3])?;
        let frame = Self {
            increment: tables.u64("increment", &[])?[0],
            stage: tables.text("stage", &[])?[0].clone(),
            time_s: number("time_s")?,
            thickness_m: number("thickness_m")?,
            axial_strain: known("axial_strain")?,
            axial_stress_pa: known("axial_stress_pa")?,
            origin_m: [origin[0], origin[1]],
            cell_m: Some([cell[0], cell[1], cell[2]]).filter(|cell| cell[0] > 0.0),
            materials: column("materials.name")?,
            groups: column("groups.name")?,
            bodies: bodies(tables)?,
            pairs: pairs(tables)?,
            walls: walls(tables)?,
            membranes: membranes(tables)?,
        };
        frame.check()?;
        Ok(frame)
    }

    /// Checks that identities ascend, and that indices are in range.
    fn check(&self) -> Result<(), TableError> {
        let bad = |name: &str, row: Option<usize>| match row {
            Some(row) => {
                Err(TableError::at(name, format!("the value in row {row} is out of range")))
            }
            None => Ok(()),
        };
        let bodies = &self.bodies;
        if let Some(row) = bodies.id.windows(2).position(|pair| pair[0] >= pair[1]) {
            return Err(TableError::at("bodies.id", format!("does not ascend in row {}", row + 1)));
        }
        let beyond = |index: &u32, end: usize| *index as usize >= end;
        let material = bodies.material.iter().position(|m| beyond(m, self.materials.len()));
        bad("bodies.material", material)?;
        let group = |g: &u32| *g != NONE && beyond(g, self.groups.len());
        bad("bodies.group", bodies.group.iter().position(group))?;
        bad("bodies.fragment", bodies.fragment.iter().position(|id| self.row(*id).is_none()))?;
        let state = self.pairs.state.iter().position(|s| usize::from(*s) >= STATES.len());
        bad("pairs.state", state)?;
        bad("pairs.a", self.pairs.a.iter().position(|id| self.row(*id).is_none()))?;
        let is_body = |id: &u32| self.row(*id).is_some() || self.walls.id.contains(id);
        bad("pairs.b", self.pairs.b.iter().position(|id| !is_body(id)))?;
        let membranes = &self.membranes;
        bad("membranes.body", membranes.body.iter().position(|id| !is_body(id)))?;
        from_all("walls.first_point", &self.walls.first_point, self.walls.point_m.len())?;
        from_all("membranes.first_point", &membranes.first_point, membranes.point_m.len())
    }
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

fn membranes(tables: &Tables) -> Result<FrameMembranes, TableError> {
    let n = tables.rows("membranes.name")?;
    let points = tables.rows("membranes.point_m")?;
    Ok(FrameMembranes {
        name: tables.text("membranes.name", &[n])?.to_vec(),
        is_closed: tables.bool("membranes.is_closed", &[n])?.to_vec(),
        first_point: tables.u32("membranes.first_point", &[n + 1])?.to_vec(),
        body: tables.u32("membranes.body", &[points])?.to_vec(),
        point_m: tables.vectors("membranes.point_m", points)?,
    })
}

fn bodies(tables: &Tables) -> Result<FrameBodies, TableError> {
    let n = tables.rows("bodies.id")?;
    let numbers = |name: &str| Ok::<_, TableError>(tables.f32(name, &[n])?.to_vec());
    let counts = |name: &str| Ok::<_, TableError>(tables.u32(name, &[n])?.to_vec());
    Ok(FrameBodies {
        id: counts("bodies.id")?,
        offset_m: tables.f32_rows("bodies.offset_m", n)?,
        radius_m: numbers("bodies.radius_m")?,
        displacement_m: tables.f32_rows("bodies.displacement_m", n)?,
        rotation_rad: numbers("bodies.rotation_rad")?,
        velocity_m_s: tables.f32_rows("bodies.velocity_m_s", n)?,
        angular_velocity_rad_s: numbers("bodies.angular_velocity_rad_s")?,
        material: counts("bodies.material")?,
        group: counts("bodies.group")?,
        stress_pa: tables.f32_rows("bodies.stress_pa", n)?,
        fragment: counts("bodies.fragment")?,
    })
}

fn pairs(tables: &Tables) -> Result<FramePairs, TableError> {
    let n = tables.rows("pairs.a")?;
    let numbers = |name: &str| Ok::<_, TableError>(tables.f32(name, &[n])?.to_vec());
    let counts = |name: &str| Ok::<_, TableError>(tables.u32(name, &[n])?.to_vec());
    Ok(FramePairs {
        a: counts("pairs.a")?,
        b: counts("pairs.b")?,
        bond: counts("pairs.bond")?,
        state: tables.u8("pairs.state", &[n])?.to_vec(),
        p_n: numbers("pairs.p_n")?,
        q_n: numbers("pairs.q_n")?,
        tau_nm: numbers("pairs.tau_nm")?,
        gap_m: numbers("pairs.gap_m")?,
        angle_rad: numbers("pairs.angle_rad")?,
    })
}

fn walls(tables: &Tables) -> Result<FrameWalls, TableError> {
    let n = tables.rows("walls.id")?;
    Ok(FrameWalls {
        id: tables.u32("walls.id", &[n])?.to_vec(),
        name: tables.text("walls.name", &[n])?.to_vec(),
        is_thin: tables.bool("walls.is_thin", &[n])?.to_vec(),
        force: tables.vectors("walls.force", n)?,
        first_point: tables.u32("walls.first_point", &[n + 1])?.to_vec(),
        point_m: tables.vectors("walls.point_m", tables.rows("walls.point_m")?)?,
    })
}
