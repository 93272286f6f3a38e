//! Who vouches for a certificate of a plan: an ed25519 signature beside it.
//!
//! Keys are files as `openssl genpkey -algorithm ed25519` and `openssl pkey -pubout` write them. What is
//! signed are the hashes of plan and certificate; the plan's holds that of its motion.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use ed25519_dalek::pkcs8::{DecodePrivateKey, DecodePublicKey};
use ed25519_dalek::{Signature, Signer, SigningKey, VerifyingKey};
use serde::{Deserialize, Serialize};

use crate::output;
use crate::provenance::{self, hex, read, sha256};

/// The value of `format` that is written and read here.
const FORMAT: &str = "scandent-signature/1";

/// What stands in the file beside a certificate; hashes, key and signature hexadecimal.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Signed {
    format: String,
    plan_sha256: String,
    certificate_sha256: String,
    public_key: String,
    signature: String,
}

impl Signed {
    fn message(&self) -> Vec<u8> {
        let (plan, certificate) = (&self.plan_sha256, &self.certificate_sha256);
        format!("{FORMAT}\nplan {plan}\ncertificate {certificate}\n").into_bytes()
    }
}

/// Signs the certificate of a plan with the private key of a file; where the signature went.
///
/// # Errors
/// Files that cannot be read or written; what is no such key.
pub fn sign(plan: &Path, certificate: &Path, key: &Path) -> Result<PathBuf> {
    let key = SigningKey::from_pkcs8_pem(&text("key", key)?)
        .map_err(|error| anyhow!("{}: no private ed25519 key: {error}", key.display()))?;
    let mut signed = Signed {
        format: FORMAT.to_owned(),
        plan_sha256: sha256(&read("plan", plan)?),
        certificate_sha256: sha256(&std::fs::read(certificate)?),
        public_key: hex(key.verifying_key().as_bytes()),
        signature: String::new(),
    };
    signed.signature = hex(&key.sign(&signed.message()).to_bytes());
    let path = beside(certificate);
    output::write_json(&path, &signed)?;
    Ok(path)
}

/// Holds that the owner of a public key signed this certificate of this plan.
///
/// # Errors
/// A plan, certificate, key or signature that is another; files that cannot be read.
pub fn check(plan: &Path, certificate: &Path, key: &Path) -> Result<()> {
    let key = VerifyingKey::from_public_key_pem(&text("key", key)?)
        .map_err(|error| anyhow!("{}: no public ed25519 key: {error}", key.display()))?;
    let path = beside(certificate);
    let name = path.display();
    let signed: Signed = serde_json::from_str(&text("signature", &path)?)
        .with_context(|| format!("{name}: no signature"))?;
    if signed.format != FORMAT {
        bail!("{name}: the format is {:?}, not {FORMAT:?}", signed.format);
    }
    for (role, path, hash) in [
        ("plan", plan, &signed.plan_sha256),
        ("certificate", certificate, &signed.certificate_sha256),
    ] {
        if sha256(&read(role, path)?) != *hash {
            bail!("{name}: signs another {role} than {}", path.display());
        }
    }
    let bytes = unhex(&signed.signature).context("a signature has 64 bytes in hexadecimal");
    let signature = Signature::from_bytes(&bytes.with_context(|| name.to_string())?);
    let held = key.verify_strict(&signed.message(), &signature);
    held.map_err(|_| anyhow!("{name}: not signed by the owner of this key"))
}

/// The file beside a certificate that holds its signature.
pub fn beside(certificate: &Path) -> PathBuf {
    let mut name = OsString::from(certificate);
    name.push(".sig");
    name.into()
}

fn text(role: &str, path: &Path) -> Result<String> {
    provenance::text(path.display(), read(role, path)?)
}

fn unhex(text: &str) -> Option<[u8; 64]> {
    let digits: Option<Vec<u32>> = text.chars().map(|c| c.to_digit(16)).collect();
    let bytes = digits?
        .chunks(2)
        .map(|pair| pair.iter().fold(0, |byte, digit| 16 * byte + *digit as u8))
        .collect::<Vec<u8>>();
    (text.len() == 128).then(|| bytes.try_into().ok())?
}
