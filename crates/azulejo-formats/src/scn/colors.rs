//! Colour names.

use azulejo_scene::Rgb;
use std::collections::HashMap;

/// A hash table of all names.
#[derive(Debug)]
pub(super) struct ColorNames {
    known: HashMap<&'static str, u32>,
}

impl ColorNames {
    /// The table.
    pub fn new() -> ColorNames {
        let pairs = (SNAKE.split_ascii_whitespace()).chain(CAMEL.split_ascii_whitespace());
        let entry = |pair: &'static str| {
            let (name, hex) = pair.split_once(':')?;
            Some((name, u32::from_str_radix(hex, 16).ok()?))
        };
        ColorNames {
            known: pairs.filter_map(entry).collect(),
        }
    }

    /// The colour with a name in either spelling: `sky_blue`, `SkyBlue`.
    pub fn get(&self, name: &str) -> Option<Rgb> {
        let known = self.known.get(name);
        let value = *known.or_else(|| self.known.get(&*snake(name)?))?;
        let channel = |shift: u32| f64::from(value >> shift & 0xff) / 255.0;
        Some(Rgb::new(channel(16), channel(8), channel(0)))
    }
}

/// Converts `SkyBlue` to `sky_blue`; `None` for other spellings.
fn snake(name: &str) -> Option<String> {
    if name.contains('_') || !name.starts_with(|c: char| c.is_ascii_uppercase()) {
        return None;
    }
    let mut snake = String::new();
    for c in name.chars() {
        if c.is_ascii_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.push(c.to_ascii_lowercase());
    }
    Some(snake)
}

/// Capitalized names whose colour differs from that of the lower-case spelling, or that have no
/// lower-case spelling.
const CAMEL: &str = "Coral:ff7f00 Goldenrod:dbdb70 IndianRed1:ff6a6a Orchid:db70db \
    Plum:eaadea Tan:db9370 VioletRed:d02090 White:fcfcfc";

/// Colours as sRGB bytes, which RTRACE uses as linear values without conversion.
const SNAKE: &str = "\
    alice_blue:f0f8ff antique_white:faebd7 antique_white1:ffefdb antique_white2:eedfcc \
    antique_white3:cdc0b0 antique_white4:8b8378 aquamarine:70db93 aquamarine0:7fffd4 \
    aquamarine1:7fffd4 aquamarine2:76eec6 aquamarine3:66cdaa azure:f0ffff azure1:f0ffff \
    azure2:e0eeee azure3:c1cdcd azure4:838b8b beige:f5f5dc bisque:ffe4c4 bisque1:ffe4c4 \
    bisque2:eed5b7 bisque3:cdb79e bisque4:8b7d6b black:000000 blanched_almond:ffebcd blue:0000ff \
    blue_violet:8a2be2 brown:a52a2a burlywood:deb887 burlywood1:ffd39b burlywood2:eec591 \
    burlywood3:cdaa7d cadet_blue:5f9f9f cadet_blue1:98f5ff cadet_blue2:8ee5ee cadet_blue3:7ac5cd \
    chartreuse:7fff00 chocolate:d2691e coral:ff7f50 coral0:ff7f00 cornflower_blue:6495ed \
    cornsilk:fff8dc cornsilk1:fff8dc cornsilk2:eee8cd cornsilk3:cdc8b1 cornsilk4:8b8878 cyan:00ffff \
    dark_goldenrod:b8860b dark_green:2f4f2f dark_khaki:bdb76b dark_olive_green:4f4f2f \
    dark_olive_green1:caff70 dark_olive_green2:bcee68 dark_orange:ff8c00 dark_orchid:9932cc \
    dark_orchid1:bf3eff dark_orchid2:b23aee dark_orchid3:9a32cd dark_orchid4:68228b \
    dark_salmon:e9967a dark_sea_green:8fbc8f dark_sea_green1:c1ffc1 dark_sea_green2:b4eeb4 \
    dark_sea_green3:9bcd9b dark_sea_green4:698b69 dark_slate_blue:6b238e dark_slate_gray:2f4f4f \
    dark_slate_gray1:97ffff dark_slate_gray2:8deeee dark_slate_gray3:79cdcd dark_slate_grey:2f4f4f \
    dark_turquoise:7093db dark_violet:9400d3 deep_pink:ff1493 deep_pink1:ff1493 deep_pink2:ee1289 \
    deep_pink3:cd1076 dim_gray:696969 dim_grey:696969 firebrick:8e2323 firebrick0:b22222 \
    floral_white:fffaf0 forest_green:238e23 gainsboro:dcdcdc ghost_white:f8f8ff gold:cc7f32 \
    gold0:ffd700 goldenrod:daa520 goldenrod0:dbdb70 gray:c0c0c0 gray100:ffffff gray40:666666 \
    gray41:696969 gray42:6b6b6b gray43:6e6e6e gray44:707070 gray45:737373 gray46:757575 \
    gray47:787878 gray48:7a7a7a gray49:7d7d7d gray50:7f7f7f gray51:828282 gray52:858585 \
    gray53:878787 gray54:8a8a8a gray55:8c8c8c gray56:8f8f8f gray57:919191 gray58:949494 \
    gray59:969696 gray60:999999 gray61:9c9c9c gray62:9e9e9e gray63:a1a1a1 gray64:a3a3a3 \
    gray65:a6a6a6 gray66:a8a8a8 gray67:ababab gray68:adadad gray69:b0b0b0 gray70:b3b3b3 \
    gray71:b5b5b5 gray72:b8b8b8 gray73:bababa gray74:bdbdbd gray75:bfbfbf gray76:c2c2c2 \
    gray77:c4c4c4 gray78:c7c7c7 gray79:c9c9c9 gray80:cccccc gray81:cfcfcf gray82:d1d1d1 \
    gray83:d4d4d4 gray84:d6d6d6 gray85:d9d9d9 gray86:dbdbdb gray87:dedede gray88:e0e0e0 \
    gray89:e3e3e3 gray90:e5e5e5 gray91:e8e8e8 gray92:ebebeb gray93:ededed gray94:f0f0f0 \
    gray95:f2f2f2 gray96:f5f5f5 gray97:f7f7f7 gray98:fafafa gray99:fcfcfc green:00ff00 \
    green_yellow:adff2f grey:c0c0c0 grey100:ffffff grey40:666666 grey41:696969 grey42:6b6b6b \
    grey43:6e6e6e grey44:707070 grey45:737373 grey46:757575 grey47:787878 grey48:7a7a7a \
    grey49:7d7d7d grey50:7f7f7f grey51:828282 grey52:858585 grey53:878787 grey54:8a8a8a \
    grey55:8c8c8c grey56:8f8f8f grey57:919191 grey58:949494 grey59:969696 grey60:999999 \
    grey61:9c9c9c grey62:9e9e9e grey63:a1a1a1 grey64:a3a3a3 grey65:a6a6a6 grey66:a8a8a8 \
    grey67:ababab grey68:adadad grey69:b0b0b0 grey70:b3b3b3 grey71:b5b5b5 grey72:b8b8b8 \
    grey73:bababa grey74:bdbdbd grey75:bfbfbf grey76:c2c2c2 grey77:c4c4c4 grey78:c7c7c7 \
    grey79:c9c9c9 grey80:cccccc grey81:cfcfcf grey82:d1d1d1 grey83:d4d4d4 grey84:d6d6d6 \
    grey85:d9d9d9 grey86:dbdbdb grey87:dedede grey88:e0e0e0 grey89:e3e3e3 grey90:e5e5e5 \
    grey91:e8e8e8 grey92:ebebeb grey93:ededed grey94:f0f0f0 grey95:f2f2f2 grey96:f5f5f5 \
    grey97:f7f7f7 grey98:fafafa grey99:fcfcfc honeydew:f0fff0 honeydew1:f0fff0 honeydew2:e0eee0 \
    honeydew3:c1cdc1 honeydew4:838b83 hot_pink:ff69b4 hot_pink1:ff6eb4 hot_pink2:ee6aa7 \
    hot_pink3:cd6090 hot_pink4:8b3a62 indian_red:cd5c5c indian_red0:ff6a6a ivory:fffff0 \
    ivory1:fffff0 ivory2:eeeee0 ivory3:cdcdc1 ivory4:8b8b83 khaki:9f9f5f khaki0:f0e68c khaki1:fff68f \
    khaki2:eee685 khaki3:cdc673 lavender:e6e6fa lavender_blush:fff0f5 lavender_blush1:fff0f5 \
    lavender_blush2:eee0e5 lavender_blush3:cdc1c5 lavender_blush4:8b8386 lawn_green:7cfc00 \
    lemon_chiffon:fffacd lemon_chiffon1:fffacd lemon_chiffon2:eee9bf lemon_chiffon3:cdc9a5 \
    lemon_chiffon4:8b8970 light_blue:add8e6 light_blue1:bfefff light_blue2:b2dfee light_blue3:9ac0cd \
    light_blue4:68838b light_coral:f08080 light_cyan:e0ffff light_cyan1:e0ffff light_cyan2:d1eeee \
    light_cyan3:b4cdcd light_cyan4:7a8b8b light_goldenrod:eedd82 light_goldenrod1:ffec8b \
    light_goldenrod2:eedc82 light_goldenrod3:cdbe70 light_goldenrod_yellow:fafad2 light_gray:d3d3d3 \
    light_grey:d3d3d3 light_pink:ffb6c1 light_pink1:ffaeb9 light_pink2:eea2ad light_pink3:cd8c95 \
    light_pink4:8b5f65 light_salmon:ffa07a light_salmon1:ffa07a light_salmon2:ee9572 \
    light_sky_blue:87cefa light_sky_blue1:b0e2ff light_sky_blue2:a4d3ee light_sky_blue3:8db6cd \
    light_slate_blue:8470ff light_slate_gray:778899 light_slate_grey:778899 light_steel_blue:b0c4de \
    light_steel_blue1:cae1ff light_steel_blue2:bcd2ee light_steel_blue3:a2b5cd \
    light_steel_blue4:6e7b8b light_yellow:ffffe0 light_yellow1:ffffe0 light_yellow2:eeeed1 \
    light_yellow3:cdcdb4 light_yellow4:8b8b7a lime_green:32cc32 linen:faf0e6 magenta:ff00ff \
    magenta2:ee00ee magenta3:cd00cd magenta4:8b008b maroon:8e236b maroon0:b03060 maroon1:ff34b3 \
    maroon2:ee30a7 maroon3:cd2990 medium_aquamarine:66cdaa medium_blue:3232cc \
    medium_forest_green:6b8e23 medium_goldenrod:eaeaad medium_orchid:ba55d3 medium_orchid1:e066ff \
    medium_orchid2:d15fee medium_orchid3:b452cd medium_orchid4:7a378b medium_purple:9370db \
    medium_purple1:ab82ff medium_purple2:9f79ee medium_purple3:8968cd medium_sea_green:426f42 \
    medium_slate_blue:7b68ee medium_spring_green:7fff00 medium_turquoise:70dbdb \
    medium_violet_red:c71585 midnight_blue:2f2f4f mint_cream:f5fffa misty_rose:ffe4e1 \
    misty_rose1:ffe4e1 misty_rose2:eed5d2 misty_rose3:cdb7b5 misty_rose4:8b7d7b moccasin:ffe4b5 \
    navajo_white:ffdead navajo_white1:ffdead navajo_white2:eecfa1 navajo_white3:cdb38b navy:23238e \
    navy_blue:23238e old_lace:fdf5e6 olive_drab:6b8e23 orange:cc3232 orange0:ffa500 \
    orange_red:ff4500 orchid:da70d6 orchid0:db70db orchid1:ff83fa orchid2:ee7ae9 orchid3:cd69c9 \
    orchid4:8b4789 pale_goldenrod:eee8aa pale_green:98fb98 pale_green1:9aff9a pale_green2:90ee90 \
    pale_green3:7ccd7c pale_turquoise:afeeee pale_turquoise1:bbffff pale_turquoise2:aeeeee \
    pale_turquoise3:96cdcd pale_turquoise4:668b8b pale_violet_red:db7093 pale_violet_red1:ff82ab \
    pale_violet_red2:ee799f pale_violet_red3:cd6889 papaya_whip:ffefd5 peach_puff:ffdab9 \
    peach_puff1:ffdab9 peach_puff2:eecbad peach_puff3:cdaf95 peach_puff4:8b7765 peru:cd853f \
    pink:bc8f8f pink0:ffc0cb pink1:ffb5c5 pink2:eea9b8 pink3:cd919e pink4:8b636c plum:dda0dd \
    plum0:eaadea plum1:ffbbff plum2:eeaeee plum3:cd96cd plum4:8b668b powder_blue:b0e0e6 \
    purple:a020f0 purple1:9b30ff purple2:912cee purple3:7d26cd red:ff0000 rosy_brown:bc8f8f \
    rosy_brown1:ffc1c1 rosy_brown2:eeb4b4 rosy_brown3:cd9b9b rosy_brown4:8b6969 saddle_brown:8b4513 \
    salmon:6f4242 salmon0:fa8072 salmon1:ff8c69 sandy_brown:f4a460 sea_green:238e6b seashell:fff5ee \
    seashell1:fff5ee seashell2:eee5de seashell3:cdc5bf seashell4:8b8682 sienna:8e6b23 sienna0:a0522d \
    sky_blue:87ceeb sky_blue1:87ceff sky_blue2:7ec0ee sky_blue3:6ca6cd slate_blue:6a5acd \
    slate_blue1:836fff slate_blue2:7a67ee slate_blue3:6959cd slate_gray:708090 slate_gray1:c6e2ff \
    slate_gray2:b9d3ee slate_gray3:9fb6cd slate_gray4:6c7b8b slate_grey:708090 snow:fffafa \
    snow1:fffafa snow2:eee9e9 snow3:cdc9c9 snow4:8b8989 spring_green:00ff7f steel_blue:236b8e \
    tan:d2b48c tan0:db9370 thistle:d8bfd8 thistle1:ffe1ff thistle2:eed2ee thistle3:cdb5cd \
    thistle4:8b7b8b tomato:ff6347 turquoise:adeaea violet:4f2f4f violet0:ee82ee violet_red:cc3299 \
    violet_red0:d02090 violet_red1:ff3e96 violet_red2:ee3a8c violet_red3:cd3278 wheat:d8d8bf \
    wheat0:f5deb3 wheat1:ffe7ba wheat2:eed8ae wheat3:cdba96 wheat4:8b7e66 white:ffffff white0:fcfcfc \
    white_smoke:f5f5f5 yellow:ffff00 yellow_green:9acd32";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_spellings() {
        let colors = ColorNames::new();
        let check = |name: &str, expected: Option<[u8; 3]>| {
            let bytes = |c: Rgb| c.to_array().map(|v| (255.0 * v).round() as u8);
            assert_eq!(colors.get(name).map(bytes), expected, "{name}");
        };
        check("light_sky_blue", Some([0x87, 0xce, 0xfa]));
        check("LightSkyBlue", Some([0x87, 0xce, 0xfa]));
        check("white", Some([255; 3]));
        check("White", Some([252; 3]));
        check("IndianRed1", Some([0xff, 0x6a, 0x6a]));
        check("AntiqueWhite1", Some([0xff, 0xef, 0xdb]));
        check("dark_grey", None);
        check("DarkGrey", None);
        check("lightSkyBlue", None);
        check("Light_sky_blue", None);
        assert_eq!(colors.known.len(), 450 + 8);
    }
}
