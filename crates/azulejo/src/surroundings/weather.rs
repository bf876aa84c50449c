//! Weather files of EnergyPlus: the irradiance by the sun and by the sky, hour by hour.

use std::fmt;

/// Direct normal and diffuse horizontal irradiance from here on, W/m², say that they are missing.
const MISSING_IRRADIANCE: f64 = 9999.0;

/// Dew points from here on, °C, say that they are missing.
const MISSING_DEW_POINT: f64 = 99.9;

/// Columns up to the diffuse horizontal irradiance, the last that is used.
const COLUMNS: usize = 16;

/// Most records of an hour.
const MOST_PER_HOUR: usize = 60;

/// Days of each month of a year that is no leap year.
const DAYS: [u8; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];

/// The weather at a place, in records of an hour or less.
///
/// EnergyPlus, *Auxiliary Programs*, "EnergyPlus Weather File (EPW) Data Dictionary". Years do not matter: typical
/// years have months of several.
#[derive(Clone, Debug, PartialEq)]
pub struct WeatherFile {
    /// The name of the place.
    pub city: String,
    /// Degrees north.
    pub latitude: f64,
    /// Degrees east.
    pub longitude: f64,
    /// Hours by which local standard time is ahead of UTC.
    pub time_zone: f64,
    records: Vec<WeatherRecord>,
}

/// The weather of an hour or a part of one: means over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeatherRecord {
    /// Its line in the file, from 1.
    pub line: usize,
    /// 1 to 12.
    pub month: u8,
    /// 1 to 31.
    pub day: u8,
    /// When it begins and ends, in hours of local standard time from midnight.
    pub hours: [f64; 2],
    /// Direct normal irradiance, W/m²; `None` if it is missing.
    pub direct_normal: Option<f64>,
    /// Diffuse horizontal irradiance, W/m²; `None` if it is missing.
    pub diffuse_horizontal: Option<f64>,
    /// Dew point, °C; `None` if it is missing.
    pub dew_point: Option<f64>,
}

/// Why a text is no weather file: the line, what was found, what was expected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WeatherError {
    line: usize,
    words: String,
}

impl fmt::Display for WeatherError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.words)
    }
}

impl std::error::Error for WeatherError {}

impl WeatherError {
    fn new(line: usize, found: &str, expected: &str) -> WeatherError {
        let words = format!("found {found}, expected {expected}");
        WeatherError { line, words }
    }
}

impl WeatherFile {
    /// Reads an `.epw`.
    ///
    /// # Errors
    /// The line, what was found, what was expected.
    pub fn read(text: &str) -> Result<WeatherFile, WeatherError> {
        let mut lines = (1..)
            .zip(text.lines())
            .map(|(line, text)| Row::new(line, text));
        let place = lines.next().unwrap_or_else(|| Row::new(1, ""));
        if !place.word(0).eq_ignore_ascii_case("LOCATION") {
            return Err(place.wrong(0, "LOCATION, as a weather file of EnergyPlus (.epw) begins"));
        }
        let mut file = WeatherFile {
            city: place.word(1).to_owned(),
            latitude: place.number(6, "the latitude", -90.0..=90.0)?,
            longitude: place.number(7, "the longitude", -180.0..=180.0)?,
            time_zone: place.number(8, "the time zone in hours", -14.0..=14.0)?,
            records: Vec::new(),
        };
        let mut last = place;
        let per_hour = loop {
            let Some(row) = lines.next() else {
                return Err(last.wrong(0, "DATA PERIODS after it, and records"));
            };
            if row.word(0).eq_ignore_ascii_case("DATA PERIODS") {
                let most = MOST_PER_HOUR as f64;
                break row.number(2, "the number of records in an hour", 1.0..=most)? as usize;
            }
            last = row;
        };
        for row in lines.filter(|row| !row.is_blank()) {
            let record = WeatherRecord::read(&row, per_hour, &file.records)?;
            file.records.push(record);
        }
        Ok(file)
    }

    /// The record of an instant, in local standard time; `None` if there is none.
    pub fn record(&self, month: u8, day: u8, hour: f64) -> Option<&WeatherRecord> {
        self.records.iter().find(|record| {
            (record.month, record.day) == (month, day)
                && (record.hours[0]..record.hours[1]).contains(&hour)
        })
    }

    /// All records, in their order.
    pub fn records(&self) -> &[WeatherRecord] {
        &self.records
    }

    /// Whether the records are those of a whole year with 29 February, or without: one after the other from the first
    /// of January to the end of December, each with its irradiance.
    ///
    /// # Errors
    /// The line of the first that is missing, out of its order or without irradiance; what was found, what was expected.
    pub fn is_leap_year(&self) -> Result<bool, WeatherError> {
        let (mut expected, mut is_leap) = ((1, 1, 0.0), false);
        for record in &self.records {
            let found = (record.month, record.day, record.hours[0]);
            if found == (2, 29, 0.0) && expected == (3, 1, 0.0) {
                (expected, is_leap) = (found, true);
            }
            if found != expected {
                return Err(record.wrong(
                    &hour(found),
                    &format!("{}, as the next of a year", hour(expected)),
                ));
            }
            let irradiances = [
                ("direct normal", record.direct_normal),
                ("diffuse horizontal", record.diffuse_horizontal),
            ];
            for (name, irradiance) in irradiances {
                if irradiance.is_none() {
                    let found = format!(
                        "no {name} irradiance ({MISSING_IRRADIANCE}) of {}",
                        hour(found)
                    );
                    return Err(record.wrong(&found, "a year without gaps"));
                }
            }
            expected = record.next();
        }
        match self.records.last() {
            Some(last) if expected != (13, 1, 0.0) => {
                Err(last.wrong("the last record", &format!("{} after it", hour(expected))))
            }
            None => Err(WeatherError::new(1, "no records", "those of a year")),
            _ => Ok(is_leap),
        }
    }
}

/// A month, a day, and an hour at which a record begins, in words.
fn hour((month, day, begin): (u8, u8, f64)) -> String {
    format!("hour {} of {day}/{month}", begin as u8 + 1)
}

impl WeatherRecord {
    /// Month, day and beginning of the record after this one, where 28 February is followed by March.
    fn next(&self) -> (u8, u8, f64) {
        let end = self.hours[1];
        if end < 24.0 {
            return (self.month, self.day, end);
        }
        if self.day < DAYS[usize::from(self.month) - 1] {
            return (self.month, self.day + 1, 0.0);
        }
        (self.month + 1, 1, 0.0)
    }

    fn wrong(&self, found: &str, expected: &str) -> WeatherError {
        WeatherError::new(self.line, found, expected)
    }

    /// Reads a row; `before` are those before it.
    fn read(
        row: &Row,
        per_hour: usize,
        before: &[WeatherRecord],
    ) -> Result<WeatherRecord, WeatherError> {
        if row.words.len() < COLUMNS {
            let expected = format!("at least {COLUMNS} columns");
            return Err(row.found(&format!("{} columns", row.words.len()), &expected));
        }
        let whole = |column, what: &str, range: [f64; 2]| {
            let number = row.number(column, what, range[0]..=range[1])?;
            if number.fract() == 0.0 {
                Ok(number as u8)
            } else {
                Err(row.wrong(column, what))
            }
        };
        let month = whole(1, "a month, 1 to 12", [1.0, 12.0])?;
        let day = whole(2, "a day, 1 to 31", [1.0, 31.0])?;
        let hour = whole(3, "an hour, 1 to 24", [1.0, 24.0])?;
        let start = f64::from(hour - 1);
        // Parts of an hour follow one another, whatever their minutes are called.
        let is_of_hour = |record: &&WeatherRecord| {
            (record.month, record.day) == (month, day) && record.hours[0].floor() == start
        };
        let part = before
            .iter()
            .rev()
            .take(per_hour)
            .filter(is_of_hour)
            .count();
        if part >= per_hour {
            return Err(row.found(
                &format!("hour {hour} of {day}/{month} again"),
                &format!("{per_hour} records of it, as DATA PERIODS says"),
            ));
        }
        let [begin, end] = [part, part + 1].map(|k| start + k as f64 / per_hour as f64);
        let known = |column, what: &str, missing: f64, least: f64| {
            let value = row.number(column, what, least..=f64::MAX)?;
            Ok((value < missing).then_some(value))
        };
        Ok(WeatherRecord {
            line: row.line,
            month,
            day,
            hours: [begin, end],
            direct_normal: known(
                14,
                "direct normal irradiance, W/m²",
                MISSING_IRRADIANCE,
                0.0,
            )?,
            diffuse_horizontal: known(
                15,
                "diffuse horizontal irradiance, W/m²",
                MISSING_IRRADIANCE,
                0.0,
            )?,
            dew_point: known(7, "a dew point, °C", MISSING_DEW_POINT, -273.15)?,
        })
    }
}

/// A line, in words between commas.
struct Row<'t> {
    line: usize,
    words: Vec<&'t str>,
}

impl<'t> Row<'t> {
    fn new(line: usize, text: &'t str) -> Row<'t> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        Row {
            line,
            words: text.split(',').map(str::trim).collect(),
        }
    }

    fn is_blank(&self) -> bool {
        self.words.iter().all(|word| word.is_empty())
    }

    fn word(&self, column: usize) -> &'t str {
        self.words.get(column).copied().unwrap_or("")
    }

    fn number(
        &self,
        column: usize,
        what: &str,
        range: std::ops::RangeInclusive<f64>,
    ) -> Result<f64, WeatherError> {
        let number = self.word(column).parse::<f64>().ok();
        number
            .filter(|number| range.contains(number))
            .ok_or_else(|| self.wrong(column, what))
    }

    /// What a column has instead of something.
    fn wrong(&self, column: usize, expected: &str) -> WeatherError {
        let word: String = self.word(column).chars().take(40).collect();
        self.found(&format!("\"{word}\" in column {}", column + 1), expected)
    }

    fn found(&self, found: &str, expected: &str) -> WeatherError {
        WeatherError::new(self.line, found, expected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str =
        "LOCATION,Somewhere,-,DEU,IWEC,108660,48.13,11.70,1.0,529.0\nCOMMENTS 1,none\n";

    fn row(month: u32, day: u32, hour: u32, minute: u32, tail: &str) -> String {
        format!(
            "1989,{month},{day},{hour},{minute},?9?9,12.0,3.5,60,95600,0,1300,300,400,{tail},0,0\n"
        )
    }

    #[test]
    fn hours_end_at_their_number() {
        let rows = [
            row(6, 21, 14, 60, "600,150"),
            row(6, 21, 15, 0, "9999,9999"),
        ]
        .concat();
        let file = WeatherFile::read(&format!(
            "{HEAD}DATA PERIODS,1,1,Data,Sunday,1/1,12/31\n{rows}\n"
        ));
        let file = file.unwrap();
        assert_eq!(
            (&file.city[..], file.latitude, file.longitude),
            ("Somewhere", 48.13, 11.7)
        );
        assert_eq!(file.time_zone, 1.0);
        let record = file.record(6, 21, 13.99).unwrap();
        assert_eq!(record.hours, [13.0, 14.0]);
        assert_eq!(
            (record.direct_normal, record.diffuse_horizontal),
            (Some(600.0), Some(150.0))
        );
        assert_eq!(record.dew_point, Some(3.5));
        let missing = file.record(6, 21, 14.0).unwrap();
        assert_eq!(
            (missing.direct_normal, missing.diffuse_horizontal),
            (None, None)
        );
        assert!(file.record(6, 21, 15.0).is_none() && file.record(6, 22, 13.5).is_none());
    }

    #[test]
    fn parts_of_hours_follow_one_another() {
        let rows: String = (0..4)
            .map(|k| row(1, 1, 12, k % 2 * 30, &format!("{k},0")))
            .collect();
        let text = format!("{HEAD}DATA PERIODS,1,4,Data,Sunday,1/1,12/31\n{rows}");
        let file = WeatherFile::read(&text).unwrap();
        for (k, hour) in [11.1, 11.4, 11.6, 11.9].into_iter().enumerate() {
            assert_eq!(
                file.record(1, 1, hour).unwrap().direct_normal,
                Some(k as f64)
            );
        }
        let once_more = WeatherFile::read(&format!("{text}{}", row(1, 1, 12, 0, "1,1")));
        assert!(once_more.unwrap_err().to_string().contains("again"));
    }

    /// The records of a year, as lines.
    fn year(has_29_february: bool) -> Vec<String> {
        let mut lines = Vec::new();
        for (month, days) in (1..).zip(DAYS) {
            let days = if month == 2 && has_29_february {
                29
            } else {
                days.into()
            };
            let hours = (1..=days).flat_map(|day| (1..=24).map(move |hour| (day, hour)));
            lines.extend(hours.map(|(day, hour)| row(month, day, hour, 60, "1,1")));
        }
        lines
    }

    #[test]
    fn years_are_whole() {
        let read = |lines: &[String]| {
            let periods = "DATA PERIODS,1,1,Data,Sunday,1/1,12/31\n";
            let file = WeatherFile::read(&format!("{HEAD}{periods}{}", lines.concat()))?;
            file.is_leap_year()
        };
        assert_eq!(read(&year(false)), Ok(false));
        assert_eq!(read(&year(true)), Ok(true));
        let refused = |change: fn(&mut Vec<String>), words: &str| {
            let mut lines = year(true);
            change(&mut lines);
            let error = read(&lines).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        let gap = "line 5: found hour 3 of 1/1, expected hour 2 of 1/1";
        refused(|lines| drop(lines.remove(1)), gap);
        refused(
            |lines| lines.swap(30, 31),
            "line 34: found hour 8 of 2/1, expected hour 7 of 2/1",
        );
        refused(
            |lines| lines.insert(9, lines[8].clone()),
            "line 13: found hour 9 of 1/1 again",
        );
        refused(
            |lines| drop(lines.drain(24..48)),
            "found hour 1 of 3/1, expected hour 1 of 2/1",
        );
        refused(
            |lines| lines.truncate(8000),
            "found the last record, expected hour 9 of 29/11 after it",
        );
        refused(|lines| lines.truncate(0), "found no records");
        let missing = "line 13: found no diffuse horizontal irradiance (9999) of hour 10 of 1/1, expected a year";
        refused(|lines| lines[9] = row(1, 1, 10, 60, "1,9999"), missing);
        refused(
            |lines| lines[9] = row(1, 1, 10, 60, "9999,1"),
            "no direct normal irradiance",
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        let periods = "DATA PERIODS,1,1,Data,Sunday,1/1,12/31\n";
        for (text, words) in [
            (
                String::new(),
                "line 1: found \"\" in column 1, expected LOCATION",
            ),
            ("v 0 0 0".into(), "found \"v 0 0 0\" in column 1"),
            (
                HEAD.replace("48.13", "x"),
                "line 1: found \"x\" in column 7, expected the latitude",
            ),
            (
                HEAD.into(),
                "line 2: found \"COMMENTS 1\" in column 1, expected DATA PERIODS",
            ),
            (
                format!("{HEAD}{periods}1989,1,1,1,60,x,1,2\n"),
                "line 4: found 8 columns",
            ),
            (
                format!("{HEAD}{periods}{}", row(13, 1, 1, 0, "1,1")),
                "expected a month",
            ),
            (
                format!("{HEAD}{periods}{}", row(1, 1, 25, 0, "1,1")),
                "expected an hour",
            ),
            (
                format!("{HEAD}{periods}{}", row(1, 1, 1, 0, "-1,1")),
                "expected direct normal",
            ),
            (
                format!("{HEAD}{periods}{}", row(1, 1, 1, 0, "1,NaN")),
                "expected diffuse",
            ),
        ] {
            let error = WeatherFile::read(&text).unwrap_err().to_string();
            assert!(error.contains(words), "{error} for {text}");
        }
    }
}
