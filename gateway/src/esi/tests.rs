use super::*;
use crate::config::parse;

const ROLES: Roles = Roles { target_torque: 0x6071, actual_torque: 0x6077, position: 0x6064 };
const CIA402: &str = include_str!("../../machines/cia402.toml");

fn entry(index: &str, bits: u8) -> String {
    format!("<Entry><Index>{index}</Index><SubIndex>0</SubIndex><BitLen>{bits}</BitLen></Entry>")
}

fn pdo(tag: &str, index: &str, attributes: &str, entries: &[(&str, u8)]) -> String {
    let entries: String = entries.iter().map(|(index, bits)| entry(index, *bits)).collect();
    format!("<{tag} {attributes}><Index>{index}</Index><Name>a map</Name>{entries}</{tag}>")
}

/// A drive with a position map that is assigned and a torque map that is not.
fn file() -> String {
    let maps = [
        pdo("RxPdo", "#x1600", r#"Sm="2" Fixed="1""#, &[("#x6040", 16), ("#x607A", 32)]),
        pdo("RxPdo", "#x1601", "", &[("#x6040", 16), ("#x6060", 8), ("0", 8), ("#x6071", 16)]),
        pdo("TxPdo", "#x1A00", r#"Sm="3""#, &[("#x6041", 16), ("#x6064", 32), ("#x6061", 8)]),
        pdo("TxPdo", "#x1A01", "", &[("0", 8), ("#x6077", 16), ("#x603F", 16)]),
    ];
    format!(
        r##"<?xml version="1.0"?><EtherCATInfo><Vendor><Id>#x00000F1E</Id><Name>V</Name></Vendor>
        <Descriptions><Devices><Device Physics="YY"><Type ProductCode="#x04020010" RevisionNo="#x00000002">A
        drive</Type>{}</Device></Devices></Descriptions></EtherCATInfo>"##,
        maps.join("")
    )
}

#[test]
fn a_profile_of_the_file_is_one_of_a_configuration() {
    let listed = devices(&file()).unwrap();
    assert_eq!(
        (listed[0].vendor_id, listed[0].product_code, listed[0].revision),
        (0xF1E, 0x0402_0010, 2)
    );
    let text = template(&listed[0], &ROLES).unwrap();
    let begin = CIA402.find("[profile]").unwrap();
    let end = CIA402.find("[limits]").unwrap();
    let whole = [&CIA402[..begin], &text, &CIA402[end..]].join("\n");
    // what nobody knows yet is refused by name
    let why = parse(&whole).unwrap_err().to_string();
    assert!(why.contains("profile.counts_per_revolution = 0"), "{why}");
    assert!(why.contains("rated_torque_N_m = 0") && why.lines().count() == 2, "{why}");
    let known = whole
        .replace("counts_per_revolution = 0.0", "counts_per_revolution = 1048576.0")
        .replace("rated_torque_N_m = 0.0 }", "rated_torque_N_m = 9.0 }");
    let profile = parse(&known).unwrap().profile;
    // the assigned PDO to the drive lacks the torque; from it, two share the objects
    let indices = |maps: &[crate::config::Pdo]| maps.iter().map(|p| p.index).collect::<Vec<_>>();
    assert_eq!((indices(&profile.rx), indices(&profile.tx)), (vec![0x1601], vec![0x1A00, 0x1A01]));
}

#[test]
fn what_no_pdo_has_and_what_is_no_esi_is_told() {
    let listed = devices(&file()).unwrap();
    let roles = Roles { target_torque: 0x2071, actual_torque: 0x2077, ..ROLES };
    let why = template(&listed[0], &roles).unwrap_err().to_string();
    assert!(why.contains("no PDO of the file has 0x2071"), "{why}");
    assert!(why.contains("may be changed (0x1601)"), "{why}");
    assert!(why.contains("has 0x2077") && why.contains("(0x1a00, 0x1a01)"), "{why}");
    for (from, to, wanted) in [
        ("EtherCATInfo", "Other", "its root is <Other>"),
        ("#x00000F1E", "x", "<Id> \"x\" is no number"),
        ("RevisionNo", "Revision", "<Type> without RevisionNo"),
        ("<BitLen>16</BitLen>", "", "PDO 0x1600: <Entry> without <BitLen>"),
        ("#x1600", "#x16000", "index 0x16000 is above 0xffff"),
        ("</Devices>", "", "no XML"),
    ] {
        let why = devices(&file().replace(from, to)).unwrap_err().to_string();
        assert!(why.contains(wanted), "{why}");
    }
}

fn init_cmd(index: &str, data: &str, comment: &str) -> String {
    format!(
        "<InitCmd><Transition>PS</Transition><Index>{index}</Index><SubIndex>1</SubIndex><Data>{data}</Data>\
         <Comment>{comment}</Comment></InitCmd>"
    )
}

#[test]
fn what_the_maker_wants_to_be_written_becomes_the_start_up_list() {
    let list = [
        init_cmd("#x605A", "0600", "quick stop \"stays\""),
        init_cmd("#x2100", "78563412", ""),
        init_cmd("#x2101", "FF", "é"),
        // written by the gateway itself
        init_cmd("#x6060", "08", "mode"),
        init_cmd("#x1C12", "00", "assignment"),
        init_cmd("#x2102", "010203", "too long\nfor a list"),
    ]
    .join("");
    let with = |list: &str| {
        let mailbox = format!("<Mailbox><CoE>{list}</CoE></Mailbox></Device>");
        devices(&file().replace("</Device>", &mailbox))
    };
    let text = template(&with(&list).unwrap()[0], &ROLES).unwrap();
    assert!(
        text.contains("# 0x2102:1 has 3 bytes, allowed 1, 2 or 4: \"too long\\nfor a list\""),
        "{text}"
    );
    let table: toml::Table = toml::from_str(&text).unwrap();
    let startup: Vec<crate::config::Sdo> = table["profile"]["startup"].clone().try_into().unwrap();
    let listed: Vec<_> = startup.iter().map(|s| (s.object, s.sub, s.kind, s.value)).collect();
    use crate::config::Kind::{U16, U32, U8};
    assert_eq!(listed, [(0x605A, 1, U16, 6), (0x2100, 1, U32, 0x1234_5678), (0x2101, 1, U8, 255)]);
    assert_eq!((startup[0].name.as_str(), startup[2].name.as_str()), ("quick stop \"stays\"", "é"));
    assert!(!template(&devices(&file()).unwrap()[0], &ROLES).unwrap().contains("startup"));
    for (data, wanted) in [
        ("0", "<Data> \"0\" is no bytes"),
        ("0g", "<Data> \"0g\" is no bytes"),
        ("€a", "is no bytes"),
    ] {
        let why = with(&init_cmd("#x2100", data, "")).unwrap_err().to_string();
        assert!(
            why.starts_with("device \"A") && why.contains("<InitCmd>:") && why.contains(wanted),
            "{why}"
        );
    }
}
