//! Every program of `examples/` runs to its end; each checks its own numbers.

use std::fmt::Display;

/// What the `main` of a program returns.
trait Ending {
    fn ended(self);
}

impl Ending for () {
    fn ended(self) {}
}

impl<E: Display> Ending for Result<(), E> {
    fn ended(self) {
        self.unwrap_or_else(|e| panic!("{e}"));
    }
}

macro_rules! examples {
    ($($name:ident in $path:literal)*) => {
        $(
            #[path = $path]
            mod $name;
        )*

        mod runs {
            use super::Ending;

            $(
                #[test]
                fn $name() {
                    super::$name::main().ended();
                }
            )*
        }

        const LISTED: &[&str] = &[$($path),*];
    };
}

examples! {
    custom_measure in "../examples/custom_measure.rs"
    custom_rupture_rule in "../examples/custom_rupture_rule.rs"
    custom_stage in "../examples/custom_stage.rs"
    custom_wall in "../examples/custom_wall.rs"
    embed in "../examples/embed.rs"
    run_scene in "../examples/run_scene.rs"
    step_by_hand in "../examples/step_by_hand.rs"
}

#[test]
fn no_example_is_left_out() {
    let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/examples");
    let count = std::fs::read_dir(directory).map(Iterator::count);
    assert_eq!(count.unwrap_or_else(|e| panic!("{e}")), LISTED.len());
}
