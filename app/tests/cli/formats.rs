//! What the program writes, read back by means of its own: the header of a video, the length of a
//! sound, depth, charts and pages.

use quick_xml::Reader;
use quick_xml::events::Event;
use std::path::Path;
use tiff::decoder::{Decoder, DecodingResult};

/// What an AVI's header says, and its pictures.
#[derive(Debug)]
pub(crate) struct Avi {
    pub(crate) size: [u32; 2],
    pub(crate) frames: u32,
    pub(crate) frames_per_second: u32,
    pub(crate) pictures: Vec<image::RgbImage>,
}

fn number(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

fn place(bytes: &[u8], code: &[u8; 4]) -> usize {
    let found = bytes.windows(4).position(|window| window == code);
    found.unwrap_or_else(|| panic!("no {}", String::from_utf8_lossy(code)))
}

/// Reads a Motion-JPEG AVI.
pub(crate) fn avi(bytes: &[u8]) -> Avi {
    assert_eq!(&bytes[..4], b"RIFF");
    assert_eq!(number(bytes, 4) as usize + 8, bytes.len());
    let main = place(bytes, b"avih") + 8;
    let stream = place(bytes, b"strh") + 8;
    assert_eq!(&bytes[stream..stream + 8], b"vidsMJPG");
    let frames = number(bytes, main + 16);
    assert_eq!(number(bytes, stream + 32), frames, "the stream's count");
    let mut pictures = Vec::new();
    let mut at = place(bytes, b"movi") + 4;
    while &bytes[at..at + 4] == b"00dc" {
        let length = number(bytes, at + 4) as usize;
        let jpeg = &bytes[at + 8..at + 8 + length];
        let picture = image::load_from_memory_with_format(jpeg, image::ImageFormat::Jpeg);
        pictures.push(picture.expect("a frame").into_rgb8());
        at += 8 + length + length % 2;
    }
    assert_eq!(&bytes[at..at + 4], b"idx1");
    Avi {
        size: [number(bytes, main + 32), number(bytes, main + 36)],
        frames,
        frames_per_second: number(bytes, stream + 24) / number(bytes, stream + 20),
        pictures,
    }
}

/// The seconds that a WAV file lasts, by its header.
pub(crate) fn wav_seconds(bytes: &[u8]) -> f64 {
    assert_eq!((&bytes[..4], &bytes[8..12]), (&b"RIFF"[..], &b"WAVE"[..]));
    let bytes_per_second = number(bytes, place(bytes, b"fmt ") + 16);
    let data = place(bytes, b"data");
    assert!(data + 8 + number(bytes, data + 4) as usize <= bytes.len());
    f64::from(number(bytes, data + 4)) / f64::from(bytes_per_second)
}

/// A float32 TIFF of one band: its size and its values.
pub(crate) fn depth(path: &Path) -> ([u32; 2], Vec<f32>) {
    let file = std::fs::File::open(path).expect("the depth file");
    let mut decoder = Decoder::new(std::io::BufReader::new(file)).expect("a TIFF");
    let (width, height) = decoder.dimensions().expect("its size");
    let colour = decoder.colortype().expect("its kind");
    assert_eq!(colour, tiff::ColorType::Gray(32));
    match decoder.read_image().expect("its values") {
        DecodingResult::F32(values) => ([width, height], values),
        other => panic!("not float32: {other:?}"),
    }
}

/// The parts of XML text, all of its elements closed in their order.
fn xml_events(bytes: &[u8]) -> Vec<Event<'_>> {
    let text = std::str::from_utf8(bytes).expect("UTF-8");
    let mut reader = Reader::from_str(text);
    let (mut events, mut open) = (Vec::new(), 0);
    loop {
        let event = reader.read_event();
        match event.unwrap_or_else(|error| panic!("{error} at {}", reader.error_position())) {
            Event::Eof => break,
            event => {
                open += i32::from(matches!(event, Event::Start(_)));
                open -= i32::from(matches!(event, Event::End(_)));
                events.push(event);
            }
        }
    }
    assert_eq!(open, 0, "elements are left open");
    events
}

/// What XML text says between its elements, each piece on a line.
pub(crate) fn xml_text(bytes: &[u8]) -> String {
    let mut text = String::new();
    for event in xml_events(bytes) {
        match event {
            Event::Text(piece) => text += &piece.decode().expect("UTF-8"),
            Event::GeneralRef(name) => {
                text += match &*name.decode().expect("UTF-8") {
                    "amp" => "&",
                    "lt" => "<",
                    "gt" => ">",
                    "quot" => "\"",
                    "apos" => "'",
                    other => panic!("&{other}; is not one of XML's own"),
                }
            }
            Event::End(_) => text.push('\n'),
            _ => {}
        }
    }
    text
}

/// The values of an attribute in all elements of a name.
pub(crate) fn xml_attributes(bytes: &[u8], element: &str, attribute: &str) -> Vec<String> {
    let mut values = Vec::new();
    for event in xml_events(bytes) {
        let (Event::Start(start) | Event::Empty(start)) = event else {
            continue;
        };
        if start.name().as_ref() == element.as_bytes() {
            let value = start.try_get_attribute(attribute).expect("attributes");
            let value = value.map(|it| String::from_utf8(it.value.into_owned()));
            values.extend(value.map(|it| it.expect("UTF-8")));
        }
    }
    values
}
