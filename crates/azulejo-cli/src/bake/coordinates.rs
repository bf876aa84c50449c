//! Whether the texture coordinates that a glTF file has are kept, packed anew, or made.

use super::args::{BakeArgs, UvArg};
use super::source::BakeSource;
use super::verdict::{TestRow, place, unfit};
use crate::failure::Failure;
use crate::session::Session;
use azulejo::bake::check::{AtlasCheck, CheckOptions, check};
use azulejo::bake::unwrap::MOST_SIZE;
use azulejo::bake::{Layout, Receiver, ReceiverLayout, Resolution, UnwrapOptions, kept_layout};
use azulejo::lightmap::Coordinates;
use azulejo_formats::gltf::patch::{self, LightmapUvs, NO_PAGE};

/// The set of texture coordinates of a lightmap, by default.
const USUAL_SET: u32 = 1;

/// Where the coordinates of a lightmap come from, and where they are written.
pub struct ChosenCoordinates {
    /// For the library.
    pub coordinates: Coordinates,
    /// For the file.
    pub uvs: LightmapUvs,
}

/// Coordinates that a file has.
struct GivenCoordinates {
    set: u32,
    receivers: Vec<Receiver>,
    of_objects: Vec<ReceiverLayout>,
}

/// Chooses the coordinates of a lightmap; says why those of the file cannot be kept.
///
/// # Errors
/// They should be kept, and cannot be.
pub fn choose(
    args: &BakeArgs,
    source: &BakeSource,
    charts: &UnwrapOptions,
    session: &mut Session,
) -> Result<ChosenCoordinates, Failure> {
    let new = ChosenCoordinates {
        coordinates: Coordinates::New,
        uvs: LightmapUvs::Added(args.files.uv_set.unwrap_or(USUAL_SET)),
    };
    let must_keep = args.texels.uv == Some(UvArg::Keep);
    let refused = |why: &str| Failure::failed(format_args!("--uv keep: {why}"));
    if args.texels.uv == Some(UvArg::New) {
        return Ok(new);
    }
    // Where nothing could be kept, new charts are made in silence, unless the user insists.
    let reason = match () {
        () if !source.is_given => Some("only a glTF file has coordinates to keep"),
        () if charts.pages > 1 => {
            Some("coordinates that a file has are on one page, not on several")
        }
        () => None,
    };
    if let Some(why) = reason {
        return if must_keep {
            Err(refused(why))
        } else {
            Ok(new)
        };
    }
    // Read the coordinates of the file; where only some objects have them, that is worth a note.
    let given = match given(args, source)? {
        Ok(given) => given,
        Err(why) if must_keep => return Err(refused(&why.text)),
        Err(why) => {
            if why.is_partial {
                session.note(&format!("{}: new charts are made", why.text));
            }
            return Ok(new);
        }
    };
    // Keep coordinates that pass the tests of an atlas at the size that their page would have.
    let size = page_size(&given, charts);
    let Some(why) = given.fault(size, charts) else {
        session.note(&format!(
            "the coordinates of TEXCOORD_{} are kept",
            given.set
        ));
        return Ok(ChosenCoordinates {
            uvs: LightmapUvs::Existing(given.set),
            coordinates: Coordinates::Kept {
                of_objects: given.of_objects,
                pages: vec![[size; 2]],
            },
        });
    };
    let why = format!(
        "TEXCOORD_{} is not suitable for a lightmap of {size} × {size} texels: {why}",
        given.set
    );
    if must_keep {
        return Err(refused(&why));
    }
    // Objects with good charts that are only in each other's way need no new charts, only other places.
    if given.are_fit_alone(size, charts) {
        session.note(&format!("{why}: the charts of the objects are repacked"));
        return Ok(ChosenCoordinates {
            coordinates: Coordinates::Repacked(given.of_objects),
            ..new
        });
    }
    session.note(&format!("{why}: new charts are made"));
    Ok(new)
}

/// Why there are no coordinates to keep.
struct NoCoordinates {
    text: String,
    /// Whether some objects have some.
    is_partial: bool,
}

/// The coordinates of the file; why there are none to keep.
fn given(
    args: &BakeArgs,
    source: &BakeSource,
) -> Result<Result<GivenCoordinates, NoCoordinates>, Failure> {
    let file = source.file.patched();
    let named = patch::found_lightmap(&file, &source.origins, args.files.uv_set);
    let named = named.map_err(Failure::failed)?;
    if named.is_own {
        return Ok(Err(NoCoordinates {
            text: "those of a lightmap of azulejo's are removed with it".to_owned(),
            is_partial: false,
        }));
    }
    let set = match args.files.uv_set {
        Some(set) => set,
        None if named.is_named => named.set,
        None => USUAL_SET,
    };
    let file_coordinates =
        patch::coordinates(&file, &source.origins, set).map_err(Failure::failed)?;
    let (mut receivers, mut of_objects) = (Vec::new(), Vec::new());
    for (&object, &origin) in source.receivers.iter().zip(&source.origin_of) {
        let object = &source.scene.objects[object as usize];
        let lacks = || NoCoordinates {
            text: format!("object \"{}\" has no TEXCOORD_{set}", object.name),
            is_partial: file_coordinates.objects.iter().any(Option::is_some),
        };
        let layout = file_coordinates.objects[origin].as_ref();
        let whole = layout.filter(|l| l.pages.iter().all(|p| *p != NO_PAGE));
        let receiver = Receiver::of_object(object);
        let (Some(layout), Some(receiver)) = (whole, receiver) else {
            return Ok(Err(lacks()));
        };
        if receiver.triangles.len() != layout.uvs.len() {
            return Ok(Err(lacks()));
        }
        of_objects.push(ReceiverLayout {
            uvs: layout.uvs.clone(),
            // One page, whatever pictures the file has now.
            pages: vec![0; layout.uvs.len()],
            ..ReceiverLayout::default()
        });
        receivers.push(receiver);
    }
    Ok(Ok(GivenCoordinates {
        set,
        receivers,
        of_objects,
    }))
}

/// The size of the page on which coordinates have the resolution that is asked for.
fn page_size(given: &GivenCoordinates, charts: &UnwrapOptions) -> u32 {
    let unit = given.layout(&[1; 2], charts.crease);
    let density = unit.density(&given.receivers);
    let area: f64 = given.receivers.iter().map(Receiver::area).sum();
    let size = match charts.resolution {
        Resolution::Fill => return charts.size,
        Resolution::PerUnit(texels) => texels / density,
        Resolution::Texels(texels) => (texels / area).sqrt() / density,
    };
    let most = f64::from(charts.size.min(MOST_SIZE));
    if size.is_finite() {
        size.ceil().clamp(1.0, most) as u32
    } else {
        charts.size
    }
}

impl GivenCoordinates {
    fn layout(&self, size: &[u32; 2], crease: f64) -> Layout {
        let coordinates = self.of_objects.clone();
        kept_layout(&self.receivers, coordinates, vec![*size], crease, None)
    }

    /// What keeps them from being used as they are.
    fn fault(&self, size: u32, charts: &UnwrapOptions) -> Option<String> {
        let options = CheckOptions {
            crease: charts.crease,
            ..CheckOptions::default()
        };
        let layout = self.layout(&[size; 2], charts.crease);
        let atlas = check(&self.receivers, &layout, &options);
        if !atlas.is_complete {
            return Some("too many triangles overlap".to_owned());
        }
        unfit(&atlas, &options).map(|row| self.words(&row))
    }

    fn words(&self, row: &TestRow) -> String {
        let place = match place(row, &self.receivers) {
            place if place.is_empty() => String::new(),
            place => format!(" ({place})"),
        };
        format!("{}: {}{place}", row.name, row.found)
    }

    /// Whether the charts of each object are good, so that only the objects are in the way of one another.
    fn are_fit_alone(&self, size: u32, charts: &UnwrapOptions) -> bool {
        let options = CheckOptions {
            gap: 0.0,
            crease: charts.crease,
        };
        let is_fit = |(receiver, coordinates): (&Receiver, &ReceiverLayout)| {
            let receiver = std::slice::from_ref(receiver);
            let layout = kept_layout(
                receiver,
                vec![coordinates.clone()],
                vec![[size; 2]],
                charts.crease,
                None,
            );
            let atlas: AtlasCheck = check(receiver, &layout, &options);
            atlas.is_complete && unfit(&atlas, &options).is_none()
        };
        self.receivers.iter().zip(&self.of_objects).all(is_fit)
    }
}
