use std::io::Write;

use flate2::Compression;
use flate2::write::{DeflateEncoder, GzEncoder};

use super::*;

/// `printf 'a,b\n1,2\n' | gzip -9n`.
const GZIP: &[u8] =
    b"\x1f\x8b\x08\x00\x00\x00\x00\x00\x02\x03\x4b\xd4\x49\xe2\x32\xd4\x31\xe2\x02\x00\x7b\x07\x97\x0a\x08\x00\x00\x00";

fn read(source: &Source) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    source.open()?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// A zip after APPNOTE.TXT 6.3.10, field by field: sections 4.3.7 (local header), 4.3.12 (directory), 4.3.16 (its end).
fn zip(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let (mut file, mut directory) = (Vec::new(), Vec::new());
    let short = |value: usize| u16::try_from(value).unwrap().to_le_bytes();
    let long = |value: usize| u32::try_from(value).unwrap().to_le_bytes();
    for (name, content) in entries {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(content).unwrap();
        let packed = encoder.finish().unwrap();
        let mut crc = flate2::Crc::new();
        crc.update(content);
        let start = file.len();
        let sizes = [long(crc.sum() as usize), long(packed.len()), long(content.len())].concat();
        let common = [&[20, 0, 0, 0, 8, 0, 0, 0, 0, 0][..], &sizes, &short(name.len()), &[0, 0]].concat();
        file.extend([b"PK\x03\x04", &common[..], name.as_bytes(), &packed].concat());
        let rest = [&[0; 10][..], &long(start), name.as_bytes()].concat();
        directory.extend([b"PK\x01\x02\x14\x00", &common[..], &rest].concat());
    }
    let (count, start) = (short(entries.len()), long(file.len()));
    let end = [b"PK\x05\x06\0\0\0\0", &count[..], &count, &long(directory.len()), &start, &[0, 0]].concat();
    [file, directory, end].concat()
}

#[test]
fn what_is_packed_is_read_as_if_it_were_not_and_the_rest_as_it_is() {
    let log = b"a,b\n1,2\n".as_slice();
    let with_macos = zip(&[("log.csv", log), ("__MACOSX/._log.csv", b"\0")]);
    for packed in [log.to_vec(), GZIP.to_vec(), zip(&[("log.csv", log)]), with_macos] {
        let source = unpacked(&Source::bytes("log", packed)).unwrap();
        assert_eq!((read(&source).unwrap(), source.name()), (log.to_vec(), "log"));
    }
}

#[test]
fn it_can_be_sought_in() {
    let content: Vec<u8> = (0..200_000_u32).flat_map(u32::to_le_bytes).collect();
    let source = unpacked(&Source::bytes("log", gzip(&content))).unwrap();
    assert_eq!(source.length().unwrap(), content.len() as u64);
    let mut reader = source.open().unwrap();
    let mut number = [0; 4];
    for (to, found) in
        [(SeekFrom::Start(400_000), 100_000), (SeekFrom::Current(-8), 99_999), (SeekFrom::End(-4), 199_999)]
    {
        reader.seek(to).unwrap();
        reader.read_exact(&mut number).unwrap();
        assert_eq!(u32::from_le_bytes(number), found);
    }
    assert!(reader.seek(SeekFrom::Current(-900_000)).is_err());
}

#[test]
fn a_zip_of_several_files_names_them_and_one_that_cannot_be_read_says_why() {
    let refused = |bytes: Vec<u8>| unpacked(&Source::bytes("log.zip", bytes)).unwrap_err().to_string();
    let several = refused(zip(&[("cold.csv", b"a"), ("warm.csv", b"b")]));
    assert_eq!(
        several,
        "log.zip: the zip holds several files (cold.csv, warm.csv): unpack it and give the log that you mean"
    );
    assert!(refused(zip(&[])).contains("the zip holds no file"));
    let mut whole = zip(&[("log.csv", b"a,b\n1,2\n")]);
    let cut = whole[..whole.len() - 30].to_vec();
    assert!(refused(cut).contains("the zip cannot be read"));
    // The flag for encryption, in the local header and in the directory.
    let directory = whole.windows(4).position(|four| four == b"PK\x01\x02").unwrap();
    (whole[6], whole[directory + 8]) = (1, 1);
    assert!(refused(whole).contains("'log.csv' in the zip is encrypted"));
}

#[test]
fn damage_is_an_error_and_no_other_numbers() {
    let content: String = (0..5000).map(|row| format!("{row},{}\n", row * 7919 % 1000)).collect();
    let packed = gzip(content.as_bytes());
    let cut = unpacked(&Source::bytes("log", &packed[..packed.len() / 2])).unwrap();
    assert!(read(&cut).unwrap_err().to_string().contains("copy it again, whole"));
    let mut wrong = zip(&[("log.csv", content.as_bytes())]);
    // The check sum in the directory.
    let directory = wrong.windows(4).position(|four| four == b"PK\x01\x02").unwrap();
    wrong[directory + 16] ^= 1;
    let damaged = unpacked(&Source::bytes("log", wrong)).unwrap();
    assert!(read(&damaged).unwrap_err().to_string().contains("its check sum is wrong"));
}
