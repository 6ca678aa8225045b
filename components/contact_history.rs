//! The memory of contacts between increments, and the rows that it refers to.

use crate::body::BodyId;
use crate::contact::BodyTable;
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

/// The identity of each row of the tables that persist between increments, and the new row of each
/// former one after bodies were added or removed. A system that owns such a table updates it in
/// `IncrementSystems::Renumber`.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct KeptRows {
    /// Identity of the body of every row.
    pub ids: Vec<BodyId>,
    now: Vec<Option<u32>>,
    changed: bool,
}

impl KeptRows {
    /// Rows of the bodies of a run that is resumed.
    pub fn of(ids: Vec<BodyId>) -> Self {
        Self { ids, ..Self::default() }
    }

    /// Takes over the rows of `bodies` and records the new row of each former one.
    pub fn follow(&mut self, bodies: &BodyTable) {
        self.now.clear();
        self.changed = !self.ids.is_empty() && self.ids != bodies.ids;
        // Bodies that are appended after all others change no row.
        if !bodies.ids.starts_with(&self.ids) {
            self.now.extend(self.ids.iter().map(|id| bodies.row(*id).map(|row| row as u32)));
        }
        self.ids.clone_from(&bodies.ids);
    }

    /// Whether any row has changed.
    pub fn is_needed(&self) -> bool {
        !self.now.is_empty()
    }

    /// Whether bodies have come or gone; those that come after all others change no row.
    pub fn has_changed(&self) -> bool {
        self.changed
    }

    /// Whether a body was removed.
    pub fn has_lost(&self) -> bool {
        self.now.contains(&None)
    }

    /// New row of the body that was in `row` before; `None` if the body was removed.
    pub fn now(&self, row: u32) -> Option<u32> {
        self.now.get(row as usize).copied().flatten()
    }

    /// Gives the pairs of a list their new rows. Those with a removed body are dropped.
    pub fn renumber<T>(&self, list: &mut Vec<T>, pair: impl Fn(&mut T) -> [&mut u32; 2]) {
        list.retain_mut(|item| {
            let [a, b] = pair(item);
            let rows = self.now(*a).zip(self.now(*b));
            if let Some(rows) = rows {
                (*a, *b) = rows;
            }
            rows.is_some()
        });
    }

    /// Converts a table by former rows to one of `rows` new rows. New bodies get the default.
    pub fn table<T: Copy + Default>(&self, before: &[T], rows: usize) -> Vec<T> {
        let mut table = vec![T::default(); rows];
        for (value, now) in before.iter().zip(&self.now) {
            if let Some(entry) = now.and_then(|now| table.get_mut(now as usize)) {
                *entry = *value;
            }
        }
        table
    }
}

/// Forces of a contact at the end of the last increment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ContactMemory {
    /// Row of the first body.
    pub a: u32,
    /// Row of the second body.
    pub b: u32,
    /// Normal force at the end of the last increment, N.
    pub p: f64,
    /// Shear force at the end of the last increment, N, in the frame of the contact, which turns
    /// with the pair.
    pub q: f64,
    /// Rolling moment at the end of the last increment, N m.
    pub tau: f64,
}

/// Memory of the contacts at the start of the trial: that of the last committed increment, or that
/// after the last step of a followed motion.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct DraftHistory(pub ContactHistory);

/// Memory of the contacts that carried force, sorted by (a, b). The indices are rows of
/// [`KeptRows`].
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct ContactHistory(pub Vec<ContactMemory>);

impl ContactHistory {
    /// Updates the rows of bodies. Contacts of removed bodies are dropped.
    pub fn renumber(&mut self, rows: &KeptRows) {
        rows.renumber(&mut self.0, |m| [&mut m.a, &mut m.b]);
    }

    /// Memory of the pair (a, b); `None` if the pair carried nothing.
    pub fn get(&self, a: u32, b: u32) -> Option<&ContactMemory> {
        self.0.binary_search_by_key(&(a, b), |m| (m.a, m.b)).ok().map(|k| &self.0[k])
    }

    /// Each pair with the largest of normal force, shear force and moment / `length` (m), N.
    pub fn sizes(&self, length: f64) -> impl Iterator<Item = (u32, u32, f64)> + Clone + '_ {
        self.0.iter().map(move |m| (m.a, m.b, m.p.abs().max(m.q.abs()).max(m.tau.abs() / length)))
    }

    /// Look-up of memories for pairs (a, b) in ascending order. It is faster than
    /// [`get`](Self::get) for each pair.
    pub fn ascending<'a>(&'a self) -> impl FnMut(u32, u32) -> Option<&'a ContactMemory> {
        let mut rest = self.0.iter().peekable();
        move |a, b| {
            while rest.next_if(|m| (m.a, m.b) < (a, b)).is_some() {}
            rest.peek().copied().filter(|m| (m.a, m.b) == (a, b))
        }
    }
}
