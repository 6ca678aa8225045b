//! States of a simulation as bytes: its scene, the registered state of its world, and the laws of
//! its materials, which are settings and may have changed.

use clastic::components::material::{BondLaw, ContactLaw, Materials};
use clastic::run::state::StateView;
use clastic::run::{self, WorldState};
use clastic::scene::from_str_with;

use crate::errors::Error;
use crate::loads::{self, LoadFunction};
use crate::model::Model;

/// First bytes of a state.
const MAGIC: &[u8] = b"clastic simulation 1\n";

/// Scene text, its name, the world, and the laws of the materials.
type Content = (String, String, WorldState, Vec<(ContactLaw, Option<BondLaw>)>);

impl Model {
    /// The state after the last increment.
    pub fn save(&mut self) -> Result<Vec<u8>, Error> {
        let world = self.simulation.state()?;
        let now = self.simulation.world();
        let laws = now.resource::<Materials>().0.iter().map(|m| (m.contact, m.bond)).collect();
        let name = self.loaded.path.to_string_lossy().into_owned();
        let content: Content = (self.loaded.text.clone(), name, world, laws);
        let bytes = postcard::to_stdvec(&content).map_err(|e| Error::Engine(e.to_string()))?;
        Ok([MAGIC, &bytes].concat())
    }

    /// A simulation that goes on from a state.
    pub fn restored(bytes: &[u8]) -> Result<Self, Error> {
        let foreign = || Error::Value("not a state that `Simulation.save` has made".to_owned());
        let content = bytes.strip_prefix(MAGIC).ok_or_else(foreign)?;
        let content: Content = postcard::from_bytes(content).map_err(|_| foreign())?;
        let (text, name, state, laws) = content;
        let specimen = StateView::of(&state)?.specimen;
        let loaded = from_str_with(&text, name.as_ref(), specimen, &[])?;
        let mut app = run::app(());
        loads::add(&mut app);
        let mut simulation = run::Simulation::resume_in(app, &loaded.scene, &state)?;
        let world = simulation.world_mut();
        for (material, law) in world.resource_mut::<Materials>().0.iter_mut().zip(laws) {
            (material.contact, material.bond) = law;
        }
        Ok(Self::of(simulation, loaded))
    }

    /// Goes back, or on, to a state. A function of loads stays.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let mut other = Self::restored(bytes)?;
        if let Some(function) = self.world().remove_resource::<LoadFunction>() {
            other.world().insert_resource(function);
        }
        *self = other;
        Ok(())
    }
}
