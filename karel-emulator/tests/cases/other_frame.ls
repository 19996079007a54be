/PROG  OTHER_FRAME
/ATTR
OWNER = MNEDITOR;
/MN
   1:  UTOOL_NUM=1 ;
   2:  L P[1] 50mm/sec FINE    ;
/POS
P[1]{
   GP1:
	UF : 3, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   985.000  mm,	Y =     0.000  mm,	Z =   850.000  mm,
	W =  -180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
/END
