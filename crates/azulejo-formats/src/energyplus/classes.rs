//! The classes of objects that matter here, with the names of their fields in the order of IDF files.

/// What an object is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InputClass {
    /// The version of EnergyPlus that the file is for.
    Version,
    /// How vertices are listed, and in which coordinates.
    Rules,
    Building,
    Zone,
    /// Layers from the outside to the inside.
    Construction,
    /// A construction through which zones see each other.
    AirBoundary,
    /// Anything with an absorptance for long waves.
    Material,
    /// A surface of a zone, by its vertices.
    Detailed,
    /// A surface of a zone, as a rectangle.
    Rectangle,
    /// A window or door by its vertices.
    Opening,
    /// A window or door as a rectangle on its surface.
    RectangularOpening,
    /// What shades and stays in place when the building is turned.
    SiteShading,
    /// What shades and turns with the building.
    BuildingShading,
    /// What shades and belongs to a surface of a zone.
    ZoneShading,
    /// A rectangle that shades: of the site, or of the building.
    RectangularShading,
    /// A surface of a zone without a place.
    Mass,
    /// Something with an effect on radiation that is not read, for this reason.
    Skipped(&'static str),
}

/// A class and its fields by their names in epJSON.
///
/// In IDF files the fields precede the vertices, if it has any. `+` precedes a field that files before
/// version 9.6 lack, `-` one that ended with version 8.9.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClassLayout {
    pub name: &'static str,
    pub class: InputClass,
    /// Separated by blanks.
    fields: &'static str,
    /// The type of the surfaces, where the class says it.
    pub surface_type: &'static str,
}

/// A version of EnergyPlus: major and minor number.
pub(super) type InputVersion = (u32, u32);

/// The first versions in which walls may belong to spaces, and in which shading controls list their windows.
const SPACES: InputVersion = (9, 6);
const NO_CONTROLS: InputVersion = (9, 0);

impl ClassLayout {
    /// The fields of a version after the name, in their order.
    pub fn fields(&self, version: InputVersion) -> Vec<&'static str> {
        let known = self.fields.split_whitespace();
        known
            .filter(|field| match field.as_bytes()[0] {
                b'+' => version >= SPACES,
                b'-' => version < NO_CONTROLS,
                _ => true,
            })
            .map(bare)
            .collect()
    }

    /// The field of any version that a name means.
    pub fn field(&self, name: &str) -> Option<&'static str> {
        let mut known = self.fields.split_whitespace().map(bare);
        known.find(|field| name.eq_ignore_ascii_case(field))
    }

    /// Whether vertices follow the fields.
    pub fn has_vertices(&self) -> bool {
        self.fields.ends_with("number_of_vertices")
    }
}

fn bare(field: &'static str) -> &'static str {
    field.trim_start_matches(['+', '-'])
}

/// The class with a name, in any case.
pub(super) fn class(name: &str) -> Option<ClassLayout> {
    let mut known = CLASSES.iter();
    let &(name, class, fields, surface_type) = known.find(|c| c.0.eq_ignore_ascii_case(name))?;
    Some(ClassLayout {
        name,
        class,
        fields,
        surface_type,
    })
}

const SURFACE: &str = "surface_type construction_name zone_name +space_name outside_boundary_condition \
     outside_boundary_condition_object sun_exposure wind_exposure view_factor_to_ground \
     number_of_vertices";
const TYPED_SURFACE: &str = "construction_name zone_name +space_name outside_boundary_condition \
     outside_boundary_condition_object sun_exposure wind_exposure view_factor_to_ground \
     number_of_vertices";
/// Walls have a height, roofs and floors a width; both names are looked for.
const RECTANGLE: &str = "construction_name zone_name +space_name azimuth_angle tilt_angle starting_x_coordinate \
     starting_y_coordinate starting_z_coordinate length height";
const FLAT_RECTANGLE: &str = "construction_name zone_name +space_name azimuth_angle tilt_angle starting_x_coordinate \
     starting_y_coordinate starting_z_coordinate length width";
const INTERZONE: &str = "construction_name zone_name +space_name outside_boundary_condition_object azimuth_angle \
     tilt_angle starting_x_coordinate starting_y_coordinate starting_z_coordinate length \
     height";
const FLAT_INTERZONE: &str = "construction_name zone_name +space_name outside_boundary_condition_object azimuth_angle \
     tilt_angle starting_x_coordinate starting_y_coordinate starting_z_coordinate length \
     width";
const WINDOW: &str = "construction_name building_surface_name -shading_control_name frame_and_divider_name \
     multiplier starting_x_coordinate starting_z_coordinate length height";
const DOOR: &str = "construction_name building_surface_name multiplier starting_x_coordinate \
     starting_z_coordinate length height";
const INTERZONE_OPENING: &str = "construction_name building_surface_name outside_boundary_condition_object multiplier \
     starting_x_coordinate starting_z_coordinate length height";
const FENESTRATION: &str = "surface_type construction_name building_surface_name outside_boundary_condition_object \
     view_factor_to_ground -shading_control_name frame_and_divider_name multiplier \
     number_of_vertices";
const SHADING: &str = "transmittance_schedule_name number_of_vertices";
const SHADING_RECTANGLE: &str = "azimuth_angle tilt_angle starting_x_coordinate starting_y_coordinate \
     starting_z_coordinate length height";
const LAYERS: &str =
    "outside_layer layer_2 layer_3 layer_4 layer_5 layer_6 layer_7 layer_8 layer_9 layer_10";
const RULES: &str = "starting_vertex_position vertex_entry_direction coordinate_system \
     daylighting_reference_point_coordinate_system rectangular_surface_coordinate_system";
const BUILDING: &str = "north_axis";
const ZONE: &str = "direction_of_relative_north x_origin y_origin z_origin type multiplier";
const OPAQUE_LAYER: &str =
    "roughness thickness conductivity density specific_heat thermal_absorptance";
const NO_MASS: &str = "roughness thermal_resistance thermal_absorptance";
const GLAZING: &str = "optical_data_type window_glass_spectral_data_set_name thickness \
     solar_transmittance_at_normal_incidence front_side_solar_reflectance_at_normal_incidence \
     back_side_solar_reflectance_at_normal_incidence \
     visible_transmittance_at_normal_incidence \
     front_side_visible_reflectance_at_normal_incidence \
     back_side_visible_reflectance_at_normal_incidence \
     infrared_transmittance_at_normal_incidence front_side_infrared_hemispherical_emissivity \
     back_side_infrared_hemispherical_emissivity";
const ZONE_SHADING: &str = "base_surface_name transmittance_schedule_name number_of_vertices";
const TRANSFORM: &str = "another aspect ratio of the building: not applied";

const MASS: &str = "construction_name zone_or_zonelist_name +space_or_spacelist_name surface_area";
const PROJECTION: &str = "overhang or fin given by its window: not in the scene";

/// The classes: their names, what they are, their fields, and the type of their surfaces.
const CLASSES: &[(&str, InputClass, &str, &str)] = {
    use InputClass::*;
    &[
        ("Version", Version, "", ""),
        ("GlobalGeometryRules", Rules, RULES, ""),
        ("Building", Building, BUILDING, ""),
        ("Zone", Zone, ZONE, ""),
        ("Construction", Construction, LAYERS, ""),
        ("Construction:AirBoundary", AirBoundary, "", ""),
        ("Material", Material, OPAQUE_LAYER, ""),
        ("Material:NoMass", Material, NO_MASS, ""),
        ("WindowMaterial:Glazing", Material, GLAZING, ""),
        ("BuildingSurface:Detailed", Detailed, SURFACE, ""),
        ("Wall:Detailed", Detailed, TYPED_SURFACE, "Wall"),
        ("RoofCeiling:Detailed", Detailed, TYPED_SURFACE, "Roof"),
        ("Floor:Detailed", Detailed, TYPED_SURFACE, "Floor"),
        ("Wall:Exterior", Rectangle, RECTANGLE, "Wall"),
        ("Wall:Adiabatic", Rectangle, RECTANGLE, "Wall"),
        ("Wall:Underground", Rectangle, RECTANGLE, "Wall"),
        ("Wall:Interzone", Rectangle, INTERZONE, "Wall"),
        ("Roof", Rectangle, FLAT_RECTANGLE, "Roof"),
        ("Ceiling:Adiabatic", Rectangle, FLAT_RECTANGLE, "Ceiling"),
        ("Ceiling:Interzone", Rectangle, FLAT_INTERZONE, "Ceiling"),
        ("Floor:GroundContact", Rectangle, FLAT_RECTANGLE, "Floor"),
        ("Floor:Adiabatic", Rectangle, FLAT_RECTANGLE, "Floor"),
        ("Floor:Interzone", Rectangle, FLAT_INTERZONE, "Floor"),
        ("FenestrationSurface:Detailed", Opening, FENESTRATION, ""),
        ("Window", RectangularOpening, WINDOW, "Window"),
        ("GlazedDoor", RectangularOpening, WINDOW, "GlassDoor"),
        ("Door", RectangularOpening, DOOR, "Door"),
        (
            "Window:Interzone",
            RectangularOpening,
            INTERZONE_OPENING,
            "Window",
        ),
        (
            "GlazedDoor:Interzone",
            RectangularOpening,
            INTERZONE_OPENING,
            "GlassDoor",
        ),
        (
            "Door:Interzone",
            RectangularOpening,
            INTERZONE_OPENING,
            "Door",
        ),
        ("Shading:Site:Detailed", SiteShading, SHADING, ""),
        ("Shading:Building:Detailed", BuildingShading, SHADING, ""),
        ("Shading:Zone:Detailed", ZoneShading, ZONE_SHADING, ""),
        (
            "Shading:Site",
            RectangularShading,
            SHADING_RECTANGLE,
            "Site",
        ),
        (
            "Shading:Building",
            RectangularShading,
            SHADING_RECTANGLE,
            "Building",
        ),
        ("InternalMass", Mass, MASS, ""),
        ("Shading:Overhang", Skipped(PROJECTION), "", ""),
        ("Shading:Overhang:Projection", Skipped(PROJECTION), "", ""),
        ("Shading:Fin", Skipped(PROJECTION), "", ""),
        ("Shading:Fin:Projection", Skipped(PROJECTION), "", ""),
        ("GeometryTransform", Skipped(TRANSFORM), "", ""),
    ]
};
