//! All components, resources and plain data, for `use clastic_components::prelude::*`.

pub use crate::analysis::*;
pub use crate::attempt::*;
pub use crate::body::*;
pub use crate::bond::*;
pub use crate::cell::*;
pub use crate::collision::*;
pub use crate::contact::*;
pub use crate::contact_history::*;
pub use crate::energy::*;
pub use crate::findings::*;
pub use crate::increment::*;
pub use crate::link::*;
pub use crate::loads::*;
pub use crate::material::*;
pub use crate::measure::*;
pub use crate::membrane::*;
pub use crate::motion::*;
pub use crate::observation::*;
pub use crate::particle::*;
pub use crate::poured::*;
pub use crate::progress::*;
pub use crate::rigid_group::*;
pub use crate::rows::*;
pub use crate::wall::*;
pub use crate::wall_shape::*;
