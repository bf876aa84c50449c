//! The texts of the lessons in their languages, and what counts as an answer.

use super::texts::{TextPiece, pieces, source};
use super::*;
use crate::words::Language;
use std::collections::BTreeSet;

/// All texts of a lesson, in their order.
fn all_texts(lesson: Lesson, language: Language) -> Vec<&'static str> {
    let texts = lesson.texts(language);
    let lists = [&texts.about, &texts.steps, &texts.answer];
    let lists = lists.into_iter().flatten();
    let single = [&texts.title, &texts.question, &texts.hint];
    lists.chain(single).map(String::as_str).collect()
}

/// The numbers in a text, sorted.
fn numbers(text: &str) -> Vec<String> {
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let words = text
        .split(|c: char| !is_part(c))
        .map(|w| w.trim_matches('.'));
    let mut numbers: Vec<String> = words.filter(|w| !w.is_empty()).map(str::to_owned).collect();
    numbers.sort();
    numbers
}

#[test]
fn all_languages_have_the_same_lessons_numbers_labels_and_names() {
    for lesson in all::<Lesson>() {
        let english = all_texts(lesson, Language::English);
        for language in [Language::Spanish, Language::Portuguese] {
            let count = |l| {
                let texts = lesson.texts(l);
                [texts.about.len(), texts.steps.len(), texts.answer.len()]
            };
            assert_eq!(
                count(language),
                count(Language::English),
                "{lesson:?} {language:?}"
            );
            for (a, b) in english.iter().zip(all_texts(lesson, language)) {
                assert!(
                    !b.is_empty() && b.trim() == b && *a != b || a.starts_with("F = "),
                    "{b}"
                );
                assert_eq!(numbers(a), numbers(b), "{a}\n{b}");
                let mut marked = [*a, b].map(|text| {
                    let pieces = pieces(text).into_iter();
                    let mut marked: Vec<String> = pieces
                        .filter(|piece| !matches!(piece, TextPiece::Plain(_)))
                        .map(|piece| format!("{piece:?}"))
                        .collect();
                    marked.sort();
                    marked
                });
                assert_eq!(std::mem::take(&mut marked[0]), marked[1], "{a}\n{b}");
            }
        }
    }
    for language in Language::ALL {
        let lessons = source(language).matches("[[lesson]]").count();
        assert_eq!(lessons, Lesson::COUNT, "{language:?}");
    }
}

#[test]
fn labels_are_those_of_the_window_and_names_those_of_the_scene() {
    for lesson in all::<Lesson>() {
        let document = lesson.document();
        let objects = document.objects.iter().map(|o| o.name.as_str());
        let names: BTreeSet<&str> = objects.collect();
        for text in all_texts(lesson, Language::English) {
            for piece in pieces(text) {
                match piece {
                    TextPiece::Label("=") => assert!(
                        lesson
                            .texts(Language::English)
                            .answer
                            .iter()
                            .any(|t| t == text)
                    ),
                    TextPiece::Label(label) => {
                        let is_known = Language::Spanish.tr(label) != label || label == "Material";
                        assert!(is_known, "no label \"{label}\" in the window: {text}");
                    }
                    TextPiece::Name(name) => assert!(names.contains(name), "{name}: {names:?}"),
                    TextPiece::Plain(words) => {
                        assert!(!words.contains(['{', '}', '`']), "{words}");
                    }
                }
            }
        }
        assert!(lesson.texts(Language::English).answer[0].starts_with("{=}"));
    }
}

#[test]
fn scenes_keep_their_promises() {
    for lesson in all::<Lesson>() {
        let problems = lesson.document().scene().validate();
        assert!(problems.is_ok(), "{lesson:?}: {problems:?}");
        // A model that cannot be made would be matt.
        let scene = lesson.document().scene();
        let models = scene.materials.iter().filter(|m| m.brdf.is_some()).count();
        assert_eq!(models, if lesson == Lesson::Grazing { 2 } else { 0 });
    }
}

#[test]
fn answers_are_read_as_people_write_them() {
    use Verdict::{Right, Unreadable, Wrong};
    for (lesson, typed, expected) in [
        (Lesson::FormFactor, "0.0686", Right),
        (Lesson::FormFactor, " 0,0686 ", Right),
        (Lesson::FormFactor, "6.86e-2", Right),
        (Lesson::FormFactor, "0.07", Wrong),
        (Lesson::FormFactor, "-0.0686", Wrong),
        (Lesson::EnergyBalance, "7.78 W", Right),
        (Lesson::EnergyBalance, "7.78W", Right),
        (Lesson::Reciprocity, "1.05 m²", Right),
        (Lesson::Grazing, "54 %", Right),
        (Lesson::Grazing, "0.54", Wrong),
        (Lesson::Grazing, "", Unreadable),
        (Lesson::Grazing, "%", Unreadable),
        (Lesson::Grazing, "sixty", Unreadable),
        (Lesson::Grazing, "nan", Unreadable),
        (Lesson::Grazing, "inf", Unreadable),
        (Lesson::Grazing, "1e999", Unreadable),
    ] {
        assert_eq!(lesson.check(typed), expected, "{typed}");
    }
    for lesson in all::<Lesson>() {
        let known = lesson.known_answer();
        assert_eq!(lesson.check(&known.shown()), Right, "{}", known.shown());
        assert!(known.tolerance <= 0.03);
    }
    assert_eq!(Lesson::FormFactor.known_answer().shown(), "0.06859");
    assert_eq!(Lesson::Grazing.known_answer().shown(), "54.04 %");
}

#[test]
fn lessons_have_numbers_from_one() {
    let numbers: Vec<usize> = all::<Lesson>().map(Lesson::number).collect();
    assert_eq!(numbers, (1..=Lesson::COUNT).collect::<Vec<_>>());
    for number in [0, 9, usize::MAX] {
        assert_eq!(Lesson::from_number(number), None);
    }
}
