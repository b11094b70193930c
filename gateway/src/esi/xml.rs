//! The devices of an ESI file.

use roxmltree::{Document, Node};

use super::error::EsiError;

/// One device of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Device {
    pub name: String,
    pub vendor_id: u32,
    pub product_code: u32,
    pub revision: u32,
    /// To the drive, and from it.
    pub rx: Vec<PdoMap>,
    pub tx: Vec<PdoMap>,
    pub startup: Vec<InitCmd>,
}

/// An object that the maker wants to be written on the way to operation.
#[derive(Clone, Debug, PartialEq)]
pub struct InitCmd {
    pub object: u16,
    pub sub: u8,
    /// In the order of the bus: the lowest byte first.
    pub data: Vec<u8>,
    pub comment: String,
}

/// A PDO with its entries.
#[derive(Clone, Debug, PartialEq)]
pub struct PdoMap {
    pub index: u16,
    /// The file gives it a sync manager: it is exchanged unless something else is configured.
    pub assigned: bool,
    /// Its entries cannot be changed.
    pub fixed: bool,
    pub entries: Vec<Object>,
}

/// An entry of a PDO; object 0 is a gap.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    pub object: u16,
    pub sub: u8,
    pub bits: u8,
    pub name: String,
}

/// Every device of the text of an ESI file, or what is wrong with it.
pub fn devices(text: &str) -> Result<Vec<Device>, EsiError> {
    let document = Document::parse(text).map_err(EsiError::NotXml)?;
    let root = document.root_element();
    if root.tag_name().name() != "EtherCATInfo" {
        return Err(EsiError::NotEsi(root.tag_name().name().to_owned()));
    }
    let vendor_id = number(wanted(root, "Vendor")?, "Id")?;
    let list = wanted(wanted(root, "Descriptions")?, "Devices")?;
    let devices: Vec<_> = children(list, "Device").map(|d| device(d, vendor_id)).collect();
    let devices = devices.into_iter().collect::<Result<Vec<_>, _>>()?;
    if devices.is_empty() {
        return Err(lacks(list, "<Device>"));
    }
    Ok(devices)
}

fn device(node: Node, vendor_id: u32) -> Result<Device, EsiError> {
    let kind = wanted(node, "Type")?;
    let name = kind.text().unwrap_or("").trim().to_owned();
    of_type(node, kind, (&name, vendor_id)).map_err(EsiError::at(format!("device {name:?}")))
}

fn of_type(node: Node, kind: Node, (name, vendor_id): (&str, u32)) -> Result<Device, EsiError> {
    let attribute = |key: &str| {
        let text = kind.attribute(key).ok_or_else(|| lacks(kind, key))?;
        parse(key, text)
    };
    let maps = |tag: &str| children(node, tag).map(pdo).collect::<Result<Vec<_>, _>>();
    Ok(Device {
        vendor_id,
        product_code: attribute("ProductCode")?,
        revision: attribute("RevisionNo")?,
        rx: maps("RxPdo")?,
        tx: maps("TxPdo")?,
        startup: startup(node)?,
        name: name.to_owned(),
    })
}

/// `Mailbox/CoE/InitCmd`.
fn startup(device: Node) -> Result<Vec<InitCmd>, EsiError> {
    let coe = child(device, "Mailbox").and_then(|mailbox| child(mailbox, "CoE"));
    let list = coe.into_iter().flat_map(|coe| children(coe, "InitCmd"));
    list.map(|node| init_cmd(node).map_err(EsiError::at("<InitCmd>"))).collect()
}

fn init_cmd(node: Node) -> Result<InitCmd, EsiError> {
    let text =
        |name: &str| child(node, name).and_then(|n| n.text()).unwrap_or("").trim().to_owned();
    Ok(InitCmd {
        object: small(number(node, "Index")?)?,
        sub: byte("subindex", number(node, "SubIndex")?)?,
        data: bytes(&text("Data")).ok_or_else(|| EsiError::NoBytes(text("Data")))?,
        comment: text("Comment"),
    })
}

/// Bytes written as hexadecimal digits.
fn bytes(text: &str) -> Option<Vec<u8>> {
    let even = text.is_ascii() && text.len().is_multiple_of(2);
    let pairs = (0..text.len() / 2).map(|k| u8::from_str_radix(&text[2 * k..2 * k + 2], 16).ok());
    even.then(|| pairs.collect()).flatten()
}

fn pdo(node: Node) -> Result<PdoMap, EsiError> {
    let index = small(number(node, "Index")?)?;
    let entries = children(node, "Entry").map(entry).collect::<Result<Vec<_>, _>>();
    let entries = entries.map_err(EsiError::at(format!("PDO {index:#06x}")))?;
    let set = |key: &str| node.attribute(key).is_some_and(|v| v == "1" || v == "true");
    Ok(PdoMap { index, assigned: node.has_attribute("Sm"), fixed: set("Fixed"), entries })
}

fn entry(node: Node) -> Result<Object, EsiError> {
    let object = small(number(node, "Index")?)?;
    let sub = if child(node, "SubIndex").is_some() { number(node, "SubIndex")? } else { 0 };
    let bits = byte("bits", number(node, "BitLen")?)?;
    let name = child(node, "Name").and_then(|n| n.text()).unwrap_or("").trim().to_owned();
    Ok(Object { object, sub: byte("subindex", sub)?, bits, name })
}

fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|c| c.tag_name().name() == name)
}

fn children<'a>(node: Node<'a, 'a>, name: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(move |c| c.tag_name().name() == name)
}

/// The child of this name, which must be there.
fn wanted<'a>(node: Node<'a, 'a>, name: &str) -> Result<Node<'a, 'a>, EsiError> {
    child(node, name).ok_or_else(|| lacks(node, &format!("<{name}>")))
}

fn lacks(node: Node, part: &str) -> EsiError {
    EsiError::Missing { element: node.tag_name().name().to_owned(), part: part.to_owned() }
}

fn number(node: Node, name: &str) -> Result<u32, EsiError> {
    parse(&format!("<{name}>"), wanted(node, name)?.text().unwrap_or(""))
}

/// `#x1A00`, `0x1A00` or decimal.
fn parse(part: &str, text: &str) -> Result<u32, EsiError> {
    let trimmed = text.trim();
    let hex = trimmed.strip_prefix("#x").or_else(|| trimmed.strip_prefix("0x"));
    let number = hex.map_or_else(|| trimmed.parse(), |digits| u32::from_str_radix(digits, 16));
    let (part, text) = (part.to_owned(), text.to_owned());
    number.map_err(|_| EsiError::NoNumber { part, text })
}

fn small(value: u32) -> Result<u16, EsiError> {
    u16::try_from(value).map_err(|_| EsiError::Above { part: "index", value, most: 0xffff })
}

fn byte(part: &'static str, value: u32) -> Result<u8, EsiError> {
    u8::try_from(value).map_err(|_| EsiError::Above { part, value, most: 0xff })
}
