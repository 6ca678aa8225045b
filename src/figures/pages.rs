//! A figure as SVG, PDF or PNG.

use super::FigureError;

/// Format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Text stays text, in Liberation Sans or a font of equal metrics (Arial).
    Svg,
    /// With the font embedded.
    Pdf,
    /// Pixels.
    Png,
}

impl Format {
    /// The format of a file with this ending.
    ///
    /// # Errors
    /// If no format has this ending, or if this build does not write it.
    pub fn of(ending: Option<&str>) -> Result<Self, FigureError> {
        let format = match ending {
            Some("svg") => Self::Svg,
            Some("pdf") => Self::Pdf,
            Some("png") => Self::Png,
            _ => {
                let what = "--out: the name must end with .svg, .pdf or .png";
                return Err(FigureError::Usage(what.to_owned()));
            }
        };
        if format != Self::Svg && !cfg!(feature = "pages") {
            return Err(FigureError::Usage(
                "this build of clastic writes figures as .svg only; for .pdf and .png build it \
                 with `--features pages`"
                    .to_owned(),
            ));
        }
        Ok(format)
    }

    /// The file of a figure; a PNG with `dpi` pixels per inch.
    ///
    /// # Errors
    /// If it cannot be converted.
    #[cfg_attr(not(feature = "pages"), allow(unused_variables))]
    pub fn of_svg(self, svg: String, dpi: f64) -> Result<Vec<u8>, FigureError> {
        match self {
            Self::Svg => Ok(svg.into_bytes()),
            #[cfg(feature = "pages")]
            Self::Pdf => converted::pdf(&svg).map_err(failed),
            #[cfg(feature = "pages")]
            Self::Png => converted::png(&svg, dpi).map_err(failed),
            #[cfg(not(feature = "pages"))]
            Self::Pdf | Self::Png => Err(FigureError::Usage("lacks the feature `pages`".into())),
        }
    }
}

#[cfg(feature = "pages")]
fn failed(what: String) -> FigureError {
    FigureError::Drawing(std::io::Error::other(what))
}

#[cfg(feature = "pages")]
mod converted {
    use std::sync::Arc;

    use krilla::geom::Size;
    use krilla::page::PageSettings;
    use krilla_svg::{SurfaceExt, SvgSettings};
    use resvg::tiny_skia::{Pixmap, Transform};
    use resvg::usvg::fontdb::Database;
    use resvg::usvg::{Options, Tree};

    /// Liberation Sans 2.1.5, under the SIL Open Font License 1.1 beside it. Its letters are as
    /// wide as those of Arial and Helvetica.
    const FONT: &[u8] = include_bytes!("fonts/LiberationSans-Regular.ttf");
    /// pt in a pixel of SVG, of which an inch has 96.
    const PT: f32 = 0.75;

    fn tree(svg: &str) -> Result<Tree, String> {
        // No font of the machine, so that the bytes depend on the figure alone.
        let mut fonts = Database::new();
        fonts.load_font_data(FONT.to_vec());
        let options = Options {
            fontdb: Arc::new(fonts),
            font_family: "Liberation Sans".to_owned(),
            ..Default::default()
        };
        Tree::from_str(svg, &options).map_err(|error| error.to_string())
    }

    pub fn pdf(svg: &str) -> Result<Vec<u8>, String> {
        let tree = tree(svg)?;
        let size = Size::from_wh(PT * tree.size().width(), PT * tree.size().height());
        let size = size.ok_or("the figure has no size")?;
        let mut document = krilla::Document::new();
        let mut page = document.start_page_with(PageSettings::new(size));
        let mut surface = page.surface();
        let drawn = surface.draw_svg(&tree, size, SvgSettings::default());
        surface.finish();
        page.finish();
        drawn.ok_or("the figure cannot be drawn")?;
        document.finish().map_err(|error| format!("{error:?}"))
    }

    pub fn png(svg: &str, dpi: f64) -> Result<Vec<u8>, String> {
        let tree = tree(svg)?;
        let scale = (dpi / 96.0) as f32;
        let pixels = |length: f32| (length * scale).ceil() as u32;
        let mut map = Pixmap::new(pixels(tree.size().width()), pixels(tree.size().height()))
            .ok_or("the picture has no size, or too large a one")?;
        resvg::render(&tree, Transform::from_scale(scale, scale), &mut map.as_mut());
        map.encode_png().map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_is_the_format() {
        assert_eq!(Format::of(Some("svg")).unwrap(), Format::Svg);
        assert!(Format::of(Some("jpg")).unwrap_err().to_string().contains(".svg, .pdf or .png"));
        assert_eq!(Format::of(Some("pdf")).is_ok(), cfg!(feature = "pages"));
    }

    #[cfg(feature = "pages")]
    #[test]
    fn a_pdf_has_its_font_and_size_and_a_png_its_pixels() {
        use crate::output::plots::page::{self, Style};
        use glam::DVec2;

        let style = Style::print(84.0, 8.0);
        let mut body = String::new();
        page::text(&mut body, DVec2::new(10.0, 20.0), 8.0, "start", "#222", "strain");
        let svg = format!("{}{body}</svg>\n", style.root(DVec2::new(style.narrowest, 100.0)));
        let pdf = Format::Pdf.of_svg(svg.clone(), 0.0).unwrap();
        let text = String::from_utf8_lossy(&pdf);
        assert!(text.starts_with("%PDF") && text.contains("LiberationSans"));
        assert!(text.contains("MediaBox[0 0 238.1"), "{text}");
        assert_eq!(pdf, Format::Pdf.of_svg(svg.clone(), 0.0).unwrap());
        let png = Format::Png.of_svg(svg, 254.0).unwrap();
        // Width in the header: 84 mm at 10 pixels a mm.
        assert_eq!(u32::from_be_bytes(png[16..20].try_into().unwrap()), 840);
    }
}
