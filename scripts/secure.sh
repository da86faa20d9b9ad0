#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# scripts/secure.sh DIR [--days N] [--add NAME --may command|look] [--revoke NAME]
#
# Makes the files for DDS Security with openssl: an authority (DIR/ca), and a folder for each identity with certificate,
# key and signed permissions. Without options, it makes DIR/command (may steer and take part in a run) and DIR/look (may
# only read). Both DDS vendors read these files. Every program takes them with --secure DIR.
#
#   --days N                 validity of new certificates in days, default 365
#   --add NAME --may WHAT    adds an identity; WHAT is command or look
#   --revoke NAME            programs that start from now on refuse this identity
#
# Whoever has DIR/ca/key.pem can make identities: keep DIR/ca on one machine. Give other machines or persons the folder of
# one identity only, such as DIR/look. After --revoke, hand out the new crl.pem.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

dir="" days=365 add="" may="" revoke=""
while [ $# -gt 0 ]; do
  case "$1" in
    --days | --add | --may | --revoke) [ $# -gt 1 ] || refuse "$1 needs a value"; declare "${1#--}=$2"; shift ;;
    -*) refuse "unknown option $1 (--help)" ;;
    *) [ -z "$dir" ] || refuse "one folder, not $dir and $1"; dir="$1" ;;
  esac
  shift
done
[ -n "$dir" ] || { say "scripts/secure.sh DIR, or --help"; exit 2; }
[[ "$days" =~ ^[0-9]+$ ]] || refuse "--days $days is no number"
for name in "$add" "$revoke"; do
  [[ "$name" =~ ^[a-z0-9_-]*$ && "$name" != ca ]] || refuse "'$name' is no name: small letters, digits, - and _"
done
command -v openssl > /dev/null || fail "openssl is missing: apt-get install openssl"
umask 077
ca="$dir/ca"

# What openssl says is shown only when it fails.
quietly() { local said; said="$("$@" 2>&1)" || { say "$said"; fail "openssl failed"; }; }
sign() { quietly openssl smime -sign -in "$1" -text -out "$2" -signer "$ca/cert.pem" -inkey "$ca/key.pem"; }
make_key() { quietly openssl ecparam -name prime256v1 -genkey -noout -out "$1"; }

make_authority() {
  mkdir -p "$ca/issued"
  : > "$ca/index.txt"
  echo 1000 > "$ca/serial"
  echo 1000 > "$ca/crlnumber"
  cat > "$ca/openssl.cnf" << 'END'
[ca]
default_ca = authority
[authority]
database = $ENV::HRP_CA/index.txt
serial = $ENV::HRP_CA/serial
crlnumber = $ENV::HRP_CA/crlnumber
new_certs_dir = $ENV::HRP_CA/issued
certificate = $ENV::HRP_CA/cert.pem
private_key = $ENV::HRP_CA/key.pem
default_md = sha256
default_crl_days = 3650
policy = name_only
unique_subject = no
[name_only]
commonName = supplied
END
  make_key "$ca/key.pem"
  quietly openssl req -x509 -new -key "$ca/key.pem" -sha256 -days 3650 -subj "/CN=openhrp-dds authority" -out "$ca/cert.pem"
  quietly openssl ca -gencrl -config "$ca/openssl.cnf" -out "$ca/crl.pem"
}

# Whom a domain lets in, and what is encrypted: everybody authenticated, every packet.
write_governance() {
  cat > "$ca/governance.xml" << 'END'
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>0</min><max>230</max></id_range></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>ENCRYPT</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
END
  sign "$ca/governance.xml" "$ca/governance.p7s"
}

# write_permissions NAME WHAT
write_permissions() {
  local publish=""
  if [ "$2" = command ]; then publish="<publish><topics><topic>*</topic></topics></publish>"; fi
  cat > "$dir/$1/permissions.xml" << END
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name="$1">
      <subject_name>CN=$1</subject_name>
      <validity>
        <not_before>$(date -u -d yesterday +%Y-%m-%dT%H:%M:%S)</not_before>
        <not_after>$(date -u -d "$((days + 1)) days" +%Y-%m-%dT%H:%M:%S)</not_after>
      </validity>
      <allow_rule>
        <domains><id_range><min>0</min><max>230</max></id_range></domains>
        $publish
        <subscribe><topics><topic>*</topic></topics></subscribe>
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
END
  sign "$dir/$1/permissions.xml" "$dir/$1/permissions.p7s"
}

# make_identity NAME WHAT
make_identity() {
  [ ! -e "$dir/$1" ] || fail "$dir/$1 is there already"
  mkdir "$dir/$1"
  make_key "$dir/$1/key.pem"
  quietly openssl req -new -key "$dir/$1/key.pem" -subj "/CN=$1" -out "$dir/$1/request.pem"
  # An end that openssl takes in its two-digit year; 0 days: a certificate that is over (for tests).
  quietly openssl ca -batch -notext -config "$ca/openssl.cnf" -in "$dir/$1/request.pem" -out "$dir/$1/cert.pem" \
    -startdate "$(date -u -d yesterday +%Y%m%d%H%M%SZ)" -enddate "$(date -u -d "$days days" +%Y%m%d%H%M%SZ)"
  rm "$dir/$1/request.pem"
  write_permissions "$1" "$2"
  cp "$ca/cert.pem" "$dir/$1/ca.pem"
  cp "$ca/governance.p7s" "$ca/crl.pem" "$dir/$1/"
  echo "$2" > "$dir/$1/may"
  say "made $dir/$1: may $2, for $days days"
}

export HRP_CA="$ca"
if [ -n "$add" ] || [ -n "$revoke" ]; then
  [ -f "$ca/key.pem" ] || fail "$ca/key.pem is missing: scripts/secure.sh $dir makes it"
  if [ -n "$add" ]; then
    case "$may" in command | look) make_identity "$add" "$may" ;; *) fail "--add needs --may command or --may look" ;; esac
  fi
  if [ -n "$revoke" ]; then
    [ -f "$dir/$revoke/cert.pem" ] || fail "there is no $dir/$revoke/cert.pem"
    quietly openssl ca -config "$ca/openssl.cnf" -revoke "$dir/$revoke/cert.pem"
    quietly openssl ca -gencrl -config "$ca/openssl.cnf" -out "$ca/crl.pem"
    for each in "$dir"/*/cert.pem; do
      [ "${each%/cert.pem}" = "$ca" ] || cp "$ca/crl.pem" "${each%/cert.pem}/crl.pem"
    done
    say "revoked $revoke: programs that start from now on refuse it; copy crl.pem to folders on other machines"
  fi
  exit 0
fi
[ ! -e "$ca" ] || fail "$ca is there already: use --add NAME, --revoke NAME, or another folder"
mkdir -p "$dir"
make_authority
write_governance
make_identity command command
make_identity look look
